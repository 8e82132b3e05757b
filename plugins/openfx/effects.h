/* The effects of this bundle: what Contents/Resources/effects.json says of each graph, and the suites of the host. */

#ifndef FLOWABS_EFFECTS_H
#define FLOWABS_EFFECTS_H

#include "json.h"
#include "openfx_api.h"
#include "platform.h"
#include "text.h"

enum { MOST_EFFECTS = 256, MOST_CLIPS = 16 };

/* What is done with a parameter's value. */
typedef enum { ROLE_KNOB, ROLE_OUTPUT, ROLE_MIX, ROLE_COLORSPACE, ROLE_COLORSPACE_NAME } Role;

/* How a parameter's value is held. */
typedef enum { PARAM_DOUBLE, PARAM_INT, PARAM_CHOICE, PARAM_BOOLEAN, PARAM_RGB, PARAM_STRING } ParamType;

typedef struct Param {
    const Json *json;
    const char *name; /* the host's */
    const char *knob; /* the graph's */
    Role role;
    ParamType type;
} Param;

/* A clip that one of the graph's other `read` nodes takes its picture from. */
typedef struct Clip {
    const char *name, *label, *given, *channels;
} Clip;

typedef struct Effect {
    const Json *json;
    const char *label, *graph, *plate;
    Param *params;
    int param_count;
    Clip clips[MOST_CLIPS];
    int clip_count;
    int output_count;
} Effect;

/* Suites of the host. Those below the line may be missing: NULL. */
typedef struct Suites {
    const OfxHost *host;
    const OfxPropertySuiteV1 *props;
    const OfxImageEffectSuiteV1 *effects;
    const OfxParameterSuiteV1 *params;
    /* ---- */
    const OfxMessageSuiteV1 *message;
    const OfxMessageSuiteV2 *messages;
    const OfxProgressSuiteV1 *progress;
} Suites;

extern Suites host;

int effects_load(void);
const Effect *effects_get(int index);
const char *effects_version(void);

OfxStatus describe(const Effect *effect, OfxImageEffectHandle handle);
OfxStatus describe_in_context(const Effect *effect, OfxImageEffectHandle handle);

OfxStatus create_instance(const Effect *effect, OfxImageEffectHandle handle);
OfxStatus destroy_instance(OfxImageEffectHandle handle);
OfxStatus purge_caches(OfxImageEffectHandle handle);
OfxStatus region_of_definition(OfxImageEffectHandle handle, OfxPropertySetHandle in, OfxPropertySetHandle out);
OfxStatus regions_of_interest(OfxImageEffectHandle handle, OfxPropertySetHandle in, OfxPropertySetHandle out);
OfxStatus clip_preferences(OfxImageEffectHandle handle, OfxPropertySetHandle out);
OfxStatus is_identity(OfxImageEffectHandle handle, OfxPropertySetHandle in, OfxPropertySetHandle out);
OfxStatus render(OfxImageEffectHandle handle, OfxPropertySetHandle in);

#endif

/* An instance of an effect: one node in a host's graph, one clip on its time line. */

#ifndef FLOWABS_INSTANCE_H
#define FLOWABS_INSTANCE_H

#include "effects.h"

typedef struct Instance {
    const Effect *effect;
    OfxImageEffectHandle handle;
    char session[64]; /* its name in the server */
    OfxImageClipHandle source, mask, output;
    OfxImageClipHandle clips[MOST_CLIPS];
    OfxParamHandle *params; /* in the order of the effect's */
    int has_message;        /* a message of ours stands on the node */
} Instance;

Instance *instance_of(OfxImageEffectHandle handle);
double instance_mix(const Instance *instance, OfxTime time);
int instance_int(const Instance *instance, Role role, OfxTime time);
const char *instance_string(const Instance *instance, Role role, OfxTime time);
int instance_values(const Instance *instance, OfxTime time, Text *out, char *why);
void say(Instance *instance, const char *type, char *text);
void say_nothing(Instance *instance);

#endif

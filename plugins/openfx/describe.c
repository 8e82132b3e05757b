/* Describe an effect to the host: what it can do, its clips, its parameters. All of it stands in effects.json. */

#include <float.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "effects.h"

static const char *const PARAM_TYPES[] = {kOfxParamTypeDouble,  kOfxParamTypeInteger, kOfxParamTypeChoice,
                                          kOfxParamTypeBoolean, kOfxParamTypeRGB,     kOfxParamTypeString};

/* Return whether the host can hand over floats, of 32 or 16 bits; a host that does not say so is asked for them. */
static int host_has_floats(void) {
    int count = 0;
    char *depth = NULL;
    if (host.props->propGetDimension(host.host->host, kOfxImageEffectPropSupportedPixelDepths, &count) || !count)
        return 1;
    for (int i = 0; i < count; i++) {
        if (host.props->propGetString(host.host->host, kOfxImageEffectPropSupportedPixelDepths, i, &depth) || !depth)
            continue;
        if (strcmp(depth, kOfxBitDepthFloat) == 0 || strcmp(depth, kOfxBitDepthHalf) == 0) return 1;
    }
    return 0;
}

/* Answer OfxActionDescribe. */
OfxStatus describe(const Effect *effect, OfxImageEffectHandle handle) {
    const OfxPropertySuiteV1 *props = host.props;
    OfxPropertySetHandle own;
    if (host.effects->getPropertySet(handle, &own) != kOfxStatOK) return kOfxStatErrBadHandle;
    if (!host_has_floats()) {
        const char *why = "Flowabs works on scene light in floats; this host has pixels of 8 or 16 bits only";
        if (host.message) host.message->message(handle, kOfxMessageError, "flowabs-depth", "%s", why);
        return kOfxStatErrMissingHostFeature;
    }
    props->propSetString(own, kOfxPropLabel, 0, effect->label);
    props->propSetString(own, kOfxImageEffectPluginPropGrouping, 0, json_string(effect->json, "grouping", "Flowabs"));
    props->propSetString(own, kOfxPropPluginDescription, 0, json_string(effect->json, "description", ""));
    props->propSetString(own, kOfxPropVersionLabel, 0, effects_version());
    props->propSetString(own, kOfxImageEffectPropSupportedContexts, 0, kOfxImageEffectContextFilter);
    props->propSetString(own, kOfxImageEffectPropSupportedContexts, 1, kOfxImageEffectContextGeneral);
    props->propSetString(own, kOfxImageEffectPropSupportedPixelDepths, 0, kOfxBitDepthFloat);
    props->propSetString(own, kOfxImageEffectPropSupportedPixelDepths, 1, kOfxBitDepthHalf);
    props->propSetInt(own, kOfxImageEffectPluginPropSingleInstance, 0, 0);
    props->propSetInt(own, kOfxImageEffectPluginPropHostFrameThreading, 0, 0);
    props->propSetInt(own, kOfxImageEffectPropSupportsMultiResolution, 0, 1);
    props->propSetInt(own, kOfxImageEffectPropSupportsTiles, 0, 0); /* lines are followed through the whole picture */
    props->propSetInt(own, kOfxImageEffectPropTemporalClipAccess, 0, 0);
    props->propSetInt(own, kOfxImageEffectPropSupportsMultipleClipDepths, 0, 0);
    props->propSetString(own, kOfxImageEffectPluginRenderThreadSafety, 0, kOfxImageEffectRenderInstanceSafe);
    for (int i = 0; i < effect->param_count; i++)
        if (effect->params[i].role == ROLE_OUTPUT)
            props->propSetString(own, kOfxImageEffectPropClipPreferencesSlaveParam, 0, effect->params[i].name);
    return kOfxStatOK;
}

/* Define a clip; `optional` is also whether it may come with one channel alone. */
static OfxStatus define_clip(OfxImageEffectHandle handle, const char *name, const char *label, int optional, int mask) {
    const OfxPropertySuiteV1 *props = host.props;
    OfxPropertySetHandle clip;
    OfxStatus status = host.effects->clipDefine(handle, name, &clip);
    if (status != kOfxStatOK) return status;
    int count = 0;
    if (!mask) props->propSetString(clip, kOfxImageEffectPropSupportedComponents, count++, kOfxImageComponentRGBA);
    if (optional) props->propSetString(clip, kOfxImageEffectPropSupportedComponents, count++, kOfxImageComponentAlpha);
    if (mask) props->propSetString(clip, kOfxImageEffectPropSupportedComponents, count++, kOfxImageComponentRGBA);
    props->propSetString(clip, kOfxPropLabel, 0, label);
    props->propSetInt(clip, kOfxImageEffectPropSupportsTiles, 0, 0);
    props->propSetInt(clip, kOfxImageEffectPropTemporalClipAccess, 0, 0);
    if (optional) props->propSetInt(clip, kOfxImageClipPropOptional, 0, 1);
    if (mask) props->propSetInt(clip, kOfxImageClipPropIsMask, 0, 1);
    return kOfxStatOK;
}

/* Return whether values of a type can have keys in this host. */
static int can_animate(const Param *param) {
    int can = 1;
    const char *asks = param->type == PARAM_CHOICE    ? kOfxParamHostPropSupportsChoiceAnimation
                       : param->type == PARAM_BOOLEAN ? kOfxParamHostPropSupportsBooleanAnimation
                       : param->type == PARAM_STRING  ? kOfxParamHostPropSupportsStringAnimation
                                                      : NULL;
    if (asks && host.props->propGetInt(host.host->host, asks, 0, &can) != kOfxStatOK) can = 0;
    return can && param->role == ROLE_KNOB;
}

/* Set the range of a number, the range of its slider, and where it stands at first. */
static void define_number(const Param *param, OfxPropertySetHandle own) {
    static const char *const ends[] = {
        kOfxParamPropMin, kOfxParamPropMax, kOfxParamPropDisplayMin, kOfxParamPropDisplayMax
    };
    static const char *const keys[] = {"min", "max", "display_min", "display_max"};
    double value = json_number(param->json, "default", 0);
    for (int i = 0; i < 4; i++) {
        const Json *end = json_get(param->json, keys[i]);
        if (!end || end->type != JSON_NUMBER) continue;
        if (param->type == PARAM_DOUBLE)
            host.props->propSetDouble(own, ends[i], 0, end->number);
        else
            host.props->propSetInt(
                own, ends[i], 0,
                (int)(end->number < INT_MIN   ? INT_MIN
                      : end->number > INT_MAX ? INT_MAX
                                              : end->number)
            );
    }
    if (param->type == PARAM_DOUBLE) {
        host.props->propSetDouble(own, kOfxParamPropDefault, 0, value);
        host.props->propSetDouble(own, kOfxParamPropIncrement, 0, json_number(param->json, "increment", 0.1));
        host.props->propSetInt(own, kOfxParamPropDigits, 0, (int)json_number(param->json, "digits", 3));
    } else {
        host.props->propSetInt(own, kOfxParamPropDefault, 0, (int)value);
    }
}

/* Define a parameter; `group` is the name of its group, or "". */
static OfxStatus define_param(OfxParamSetHandle set, const Param *param, const char *group) {
    const OfxPropertySuiteV1 *props = host.props;
    OfxPropertySetHandle own;
    OfxStatus status = host.params->paramDefine(set, PARAM_TYPES[param->type], param->name, &own);
    if (status != kOfxStatOK) return status;
    const Json *value = json_get(param->json, "default");
    props->propSetString(own, kOfxPropLabel, 0, json_string(param->json, "label", param->name));
    props->propSetString(own, kOfxParamPropHint, 0, json_string(param->json, "hint", ""));
    props->propSetInt(own, kOfxParamPropAnimates, 0, can_animate(param) || param->role == ROLE_MIX);
    if (*group) props->propSetString(own, kOfxParamPropParent, 0, group);
    int place = 0;
    switch (param->type) {
    case PARAM_DOUBLE:
    case PARAM_INT:
        define_number(param, own);
        break;
    case PARAM_CHOICE:
        for (const Json *each = json_at(json_get(param->json, "labels"), 0); each; each = each->next)
            props->propSetString(own, kOfxParamPropChoiceOption, place++, each->string ? each->string : "");
        props->propSetInt(own, kOfxParamPropDefault, 0, (int)json_number(param->json, "default", 0));
        break;
    case PARAM_BOOLEAN:
        props->propSetInt(own, kOfxParamPropDefault, 0, json_true(param->json, "default"));
        break;
    case PARAM_RGB:
        for (const Json *each = json_at(value, 0); each && place < 3; each = each->next)
            props->propSetDouble(own, kOfxParamPropDefault, place++, each->number);
        break;
    case PARAM_STRING:
        props->propSetString(own, kOfxParamPropDefault, 0, json_string(param->json, "default", ""));
        break;
    }
    return kOfxStatOK;
}

/* Define the parameters in their order, each group before the first that is in it. */
static OfxStatus define_params(const Effect *effect, OfxParamSetHandle set) {
    const char *last = "";
    for (int i = 0; i < effect->param_count; i++) {
        const Param *param = &effect->params[i];
        const char *group = json_string(param->json, "group", ""),
                   *label = json_string(param->json, "group_label", group);
        OfxPropertySetHandle own;
        OfxStatus status;
        if (*group && strcmp(group, last) != 0) { /* effects.json has those of a group side by side */
            status = host.params->paramDefine(set, kOfxParamTypeGroup, group, &own);
            if (status != kOfxStatOK) return status;
            host.props->propSetString(own, kOfxPropLabel, 0, label);
        }
        last = group;
        status = define_param(set, param, group);
        if (status != kOfxStatOK) return status;
    }
    return kOfxStatOK;
}

/* Answer OfxImageEffectActionDescribeInContext: filter and general have the same clips and parameters. */
OfxStatus describe_in_context(const Effect *effect, OfxImageEffectHandle handle) {
    OfxParamSetHandle set;
    OfxStatus status = define_clip(handle, kOfxImageEffectSimpleSourceClipName, "Source", 0, 0);
    for (int i = 0; status == kOfxStatOK && i < effect->clip_count; i++)
        status = define_clip(handle, effect->clips[i].name, effect->clips[i].label, 1, 0);
    if (status == kOfxStatOK) status = define_clip(handle, "Mask", "Mask", 1, 1);
    if (status == kOfxStatOK) status = define_clip(handle, kOfxImageEffectOutputClipName, "Output", 0, 0);
    if (status == kOfxStatOK) status = host.effects->getParamSet(handle, &set);
    return status == kOfxStatOK ? define_params(effect, set) : status;
}

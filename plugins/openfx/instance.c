/* An instance of an effect: its handles, the values of its parameters, its messages, and the actions that are no work.
 */

#include "instance.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server.h"

/* Return the instance behind the host's handle; NULL where it was never made. */
Instance *instance_of(OfxImageEffectHandle handle) {
    OfxPropertySetHandle own;
    void *found = NULL;
    if (host.effects->getPropertySet(handle, &own) != kOfxStatOK) return NULL;
    host.props->propGetPointer(own, kOfxPropInstanceData, 0, &found);
    return found;
}

/* Get a clip's handle: NULL where the host has left an optional clip out. */
static OfxImageClipHandle clip_of(OfxImageEffectHandle handle, const char *name) {
    OfxImageClipHandle clip = NULL;
    return host.effects->clipGetHandle(handle, name, &clip, NULL) == kOfxStatOK ? clip : NULL;
}

/* Answer OfxActionCreateInstance. */
OfxStatus create_instance(const Effect *effect, OfxImageEffectHandle handle) {
    static Lock counting = LOCK_START;
    static unsigned long count;
    OfxPropertySetHandle own;
    OfxParamSetHandle set;
    if (host.effects->getPropertySet(handle, &own) != kOfxStatOK) return kOfxStatErrBadHandle;
    if (host.effects->getParamSet(handle, &set) != kOfxStatOK) return kOfxStatErrBadHandle;
    Instance *instance = calloc(1, sizeof *instance);
    if (instance) instance->params = calloc((size_t)effect->param_count + 1, sizeof *instance->params);
    if (!instance || !instance->params) {
        free(instance);
        return kOfxStatErrMemory;
    }
    lock(&counting);
    snprintf(instance->session, sizeof instance->session, "openfx-%ld-%lu", process_id(), ++count);
    unlock(&counting);
    instance->effect = effect;
    instance->handle = handle;
    instance->source = clip_of(handle, kOfxImageEffectSimpleSourceClipName);
    instance->output = clip_of(handle, kOfxImageEffectOutputClipName);
    instance->mask = clip_of(handle, "Mask");
    for (int i = 0; i < effect->clip_count; i++) instance->clips[i] = clip_of(handle, effect->clips[i].name);
    for (int i = 0; i < effect->param_count; i++)
        host.params->paramGetHandle(set, effect->params[i].name, &instance->params[i], NULL);
    host.props->propSetPointer(own, kOfxPropInstanceData, 0, instance);
    return kOfxStatOK;
}

/* Answer OfxActionDestroyInstance: the server lets go of what it holds for it. */
OfxStatus destroy_instance(OfxImageEffectHandle handle) {
    OfxPropertySetHandle own;
    Instance *instance = instance_of(handle);
    if (!instance) return kOfxStatReplyDefault;
    server_forget(instance->session);
    if (host.effects->getPropertySet(handle, &own) == kOfxStatOK)
        host.props->propSetPointer(own, kOfxPropInstanceData, 0, NULL);
    free(instance->params);
    free(instance);
    return kOfxStatOK;
}

/* Answer OfxActionPurgeCaches: the host is short of memory. */
OfxStatus purge_caches(OfxImageEffectHandle handle) {
    Instance *instance = instance_of(handle);
    if (instance) server_forget(instance->session);
    server_purge();
    return kOfxStatOK;
}

/* ---------------------------------------------------------------------- values */

/* Return the place of the parameter with a role, or -1. */
static int param_with(const Instance *instance, Role role) {
    for (int i = 0; i < instance->effect->param_count; i++)
        if (instance->effect->params[i].role == role && instance->params[i]) return i;
    return -1;
}

/* Return how much of the result is to be seen, from 0 to 1. */
double instance_mix(const Instance *instance, OfxTime time) {
    double mix = 1;
    int place = param_with(instance, ROLE_MIX);
    if (place >= 0) host.params->paramGetValueAtTime(instance->params[place], time, &mix);
    return mix > 1 ? 1 : mix > 0 ? mix : 0;
}

/* Return the value of a choice, 0 where the effect has no such parameter. */
int instance_int(const Instance *instance, Role role, OfxTime time) {
    int value = 0, place = param_with(instance, role);
    if (place >= 0) host.params->paramGetValueAtTime(instance->params[place], time, &value);
    return value;
}

/* Return the value of a text, which the host keeps; "" where the effect has no such parameter. */
const char *instance_string(const Instance *instance, Role role, OfxTime time) {
    char *value = NULL;
    int place = param_with(instance, role);
    if (place >= 0) host.params->paramGetValueAtTime(instance->params[place], time, &value);
    return value ? value : "";
}

/* Add a choice's word; return whether there is one. */
static int add_choice(const Param *param, int value, Text *out, char *why) {
    const Json *list = json_get(param->json, "words"), *word = value >= 0 ? json_at(list, value) : NULL;
    if (!word || !word->string) {
        snprintf(
            why, WHY_ROOM, "parameter %s: expected a choice of 0 to %d, found %d", param->name, json_count(list) - 1,
            value
        );
        return 0;
    }
    text_add_string(out, word->string);
    return 1;
}

/* Add the value of a knob as JSON; return 1, 0 for one that stays as the graph has it, -1 for one that is wrong. */
static int add_value(const Param *param, OfxParamHandle handle, OfxTime time, Text *out, char *why) {
    int whole = 0, well = 1;
    double number = 0, green = 0, blue = 0;
    char *string = NULL;
    OfxStatus status = kOfxStatOK;
    Text value = {0};
    switch (param->type) {
    case PARAM_DOUBLE:
        status = host.params->paramGetValueAtTime(handle, time, &number);
        text_add_number(&value, number);
        break;
    case PARAM_RGB:
        status = host.params->paramGetValueAtTime(handle, time, &number, &green, &blue);
        text_add(&value, "[");
        text_add_number(&value, number);
        text_add(&value, ", ");
        text_add_number(&value, green);
        text_add(&value, ", ");
        text_add_number(&value, blue);
        text_add(&value, "]");
        break;
    case PARAM_STRING:
        status = host.params->paramGetValueAtTime(handle, time, &string);
        text_add_string(&value, string ? string : "");
        break;
    case PARAM_INT:
    case PARAM_CHOICE:
    case PARAM_BOOLEAN:
        status = host.params->paramGetValueAtTime(handle, time, &whole);
        number = whole;
        if (param->type == PARAM_INT) text_add(&value, "%d", whole);
        if (param->type == PARAM_BOOLEAN) text_add(&value, whole ? "true" : "false");
        if (param->type == PARAM_CHOICE) well = add_choice(param, whole, &value, why);
        break;
    }
    if (status != kOfxStatOK) {
        snprintf(why, WHY_ROOM, "parameter %s: the host gives no value", param->name);
        well = 0;
    }
    /* A knob that moves along a curve of the graph goes on doing so until somebody turns it. */
    int untouched = json_true(param->json, "curve") && number == json_number(param->json, "default", 0);
    if (well && !untouched) {
        text_add_string(out, param->knob);
        text_add(out, ": %s", value.chars);
    }
    text_free(&value);
    return well ? !untouched : -1;
}

/* Add every knob's value at a time, as a JSON object; return whether all is well, `why` says what is not. */
int instance_values(const Instance *instance, OfxTime time, Text *out, char *why) {
    const char *comma = "";
    text_add(out, "{");
    for (int i = 0; i < instance->effect->param_count; i++) {
        const Param *param = &instance->effect->params[i];
        if (param->role != ROLE_KNOB || !instance->params[i]) continue;
        Text value = {0};
        int added = add_value(param, instance->params[i], time, &value, why);
        if (added > 0) {
            text_add(out, "%s%s", comma, value.chars);
            comma = ", ";
        }
        text_free(&value);
        if (added < 0) return 0;
    }
    text_add(out, "}");
    return 1;
}

/* ---------------------------------------------------------------------- messages */

/* Cut off what is left of a character that did not fit whole into a text of UTF-8. */
static void cut_half_character(char *text) {
    size_t end = strlen(text), at = end;
    while (at > 0 && end - at < 3 && ((unsigned char)text[at - 1] & 0xC0) == 0x80) at--;
    if (at == 0) return;
    unsigned char first = (unsigned char)text[at - 1];
    size_t needed = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 1;
    if (needed > 1 && end - at + 1 < needed) text[at - 1] = 0;
}

/* Tell the artist something: on the node until it is over, or as the host can, or at least in its log. */
void say(Instance *instance, const char *type, char *text) {
    cut_half_character(text);
    if (host.messages) {
        host.messages->setPersistentMessage(instance->handle, type, "flowabs", "%s", text);
        instance->has_message = 1;
    } else if (host.message) {
        host.message->message(instance->handle, type, "flowabs", "%s", text);
    } else {
        fprintf(stderr, "flowabs: %s: %s\n", instance->effect->label, text);
    }
}

/* Take away what was said, since all is well again. */
void say_nothing(Instance *instance) {
    if (instance->has_message && host.messages) host.messages->clearPersistentMessage(instance->handle);
    instance->has_message = 0;
}

/* ---------------------------------------------------------------------- actions that are no work */

/* Answer OfxImageEffectActionGetRegionOfDefinition: the result is where the source is. */
OfxStatus region_of_definition(OfxImageEffectHandle handle, OfxPropertySetHandle in, OfxPropertySetHandle out) {
    Instance *instance = instance_of(handle);
    OfxRectD rect;
    double time = 0;
    host.props->propGetDouble(in, kOfxPropTime, 0, &time);
    if (!instance || !instance->source) return kOfxStatReplyDefault;
    if (host.effects->clipGetRegionOfDefinition(instance->source, time, &rect) != kOfxStatOK)
        return kOfxStatReplyDefault;
    return host.props->propSetDoubleN(out, kOfxImageEffectPropRegionOfDefinition, 4, &rect.x1);
}

/* Ask for the whole of a clip's picture. */
static void want_whole(OfxImageClipHandle clip, const char *name, OfxTime time, OfxPropertySetHandle out) {
    char property[128];
    OfxRectD rect;
    if (!clip || host.effects->clipGetRegionOfDefinition(clip, time, &rect) != kOfxStatOK) return;
    snprintf(property, sizeof property, OfxImageClipPropRoI_ "%s", name);
    host.props->propSetDoubleN(out, property, 4, &rect.x1);
}

/* Answer OfxImageEffectActionGetRegionsOfInterest: any pixel of the result may come from any pixel that goes in. The
   mask is wanted where the result is, as the host takes for granted. */
OfxStatus regions_of_interest(OfxImageEffectHandle handle, OfxPropertySetHandle in, OfxPropertySetHandle out) {
    Instance *instance = instance_of(handle);
    double time = 0;
    if (!instance) return kOfxStatReplyDefault;
    host.props->propGetDouble(in, kOfxPropTime, 0, &time);
    want_whole(instance->source, kOfxImageEffectSimpleSourceClipName, time, out);
    for (int i = 0; i < instance->effect->clip_count; i++)
        want_whole(instance->clips[i], instance->effect->clips[i].name, time, out);
    return kOfxStatOK;
}

/* Answer OfxImageEffectActionGetClipPreferences: alpha stays as the source has it; only what is drawn alone, to be put
   over something, is never opaque. A graph with curves differs from frame to frame. */
OfxStatus clip_preferences(OfxImageEffectHandle handle, OfxPropertySetHandle out) {
    Instance *instance = instance_of(handle);
    OfxPropertySetHandle source;
    char *alpha = NULL;
    if (!instance || !instance->source) return kOfxStatReplyDefault;
    if (host.effects->clipGetPropertySet(instance->source, &source) == kOfxStatOK)
        host.props->propGetString(source, kOfxImageEffectPropPreMultiplication, 0, &alpha);
    int alone = instance_int(instance, ROLE_OUTPUT, 0) > 0;
    const char *wanted = alpha && strcmp(alpha, kOfxImageUnPreMultiplied) == 0    ? kOfxImageUnPreMultiplied
                         : alpha && strcmp(alpha, kOfxImageOpaque) == 0 && !alone ? kOfxImageOpaque
                                                                                  : kOfxImagePreMultiplied;
    host.props->propSetString(out, kOfxImageEffectPropPreMultiplication, 0, wanted);
    if (json_true(instance->effect->json, "varies")) host.props->propSetInt(out, kOfxImageEffectFrameVarying, 0, 1);
    return kOfxStatOK;
}

/* Answer OfxImageEffectActionIsIdentity: at mix 0 the result is the source. */
OfxStatus is_identity(OfxImageEffectHandle handle, OfxPropertySetHandle in, OfxPropertySetHandle out) {
    Instance *instance = instance_of(handle);
    double time = 0;
    if (!instance || host.props->propGetDouble(in, kOfxPropTime, 0, &time) != kOfxStatOK) return kOfxStatReplyDefault;
    if (instance_mix(instance, time) > 0) return kOfxStatReplyDefault;
    host.props->propSetString(out, kOfxPropName, 0, kOfxImageEffectSimpleSourceClipName);
    host.props->propSetDouble(out, kOfxPropTime, 0, time);
    return kOfxStatOK;
}

/* Render a frame: the host's pictures go into shared memory, the server filters them, the result goes to the host. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "instance.h"
#include "pictures.h"
#include "server.h"

enum { ALIGNMENT = 64 };

/* All that belongs to one frame. */
typedef struct Frame {
    Instance *instance;
    OfxTime time;
    double scale;     /* of the pictures that come in: below 1 for a host's proxies */
    OfxRectI window;  /* to be filled */
    OfxRectI display; /* what is meant to be seen of the picture, y up */
    Picture source, mask, output, clips[MOST_CLIPS];
    double started;
    int shows_progress;
} Frame;

/* ---------------------------------------------------------------------- while the server is at work */

/* Tell the host how far it is, and return whether it wants the frame no more. */
static int wants_no_more(void *asked, double done) {
    Frame *frame = asked;
    OfxImageEffectHandle handle = frame->instance->handle;
    if (host.effects->abort(handle)) return 1;
    if (!host.progress || seconds_now() - frame->started < 1) return 0; /* a bar for a moment would only flicker */
    if (!frame->shows_progress)
        frame->shows_progress = host.progress->progressStart(handle, frame->instance->effect->label) == kOfxStatOK;
    return frame->shows_progress && host.progress->progressUpdate(handle, done) == kOfxStatReplyNo;
}

/* ---------------------------------------------------------------------- what the host gives */

/* Find out which part of the pixels is meant to be seen: the project's format at this scale, else the whole picture.
   Lengths follow it, so that lines keep their width when an element's bounding box changes. */
static void find_display(Frame *frame) {
    OfxPropertySetHandle own;
    double size[2] = {0, 0}, offset[2] = {0, 0}, aspect = 1;
    frame->display = frame->source.whole;
    if (host.effects->getPropertySet(frame->instance->handle, &own) != kOfxStatOK) return;
    if (host.props->propGetDoubleN(own, kOfxImageEffectPropProjectSize, 2, size) != kOfxStatOK) return;
    host.props->propGetDoubleN(own, kOfxImageEffectPropProjectOffset, 2, offset);
    if (!(size[0] >= 1 && size[1] >= 1 && size[0] < 1e6 && size[1] < 1e6)) return;
    if (!(fabs(offset[0]) < 1e6 && fabs(offset[1]) < 1e6)) return;
    host.props->propGetDouble(frame->source.image, kOfxImagePropPixelAspectRatio, 0, &aspect);
    double x = frame->scale / (aspect > 0 ? aspect : 1), y = frame->scale; /* from the project's units to pixels */
    OfxRectI format = {
        (int)floor(offset[0] * x + 0.5), (int)floor(offset[1] * y + 0.5), (int)floor((offset[0] + size[0]) * x + 0.5),
        (int)floor((offset[1] + size[1]) * y + 0.5)
    };
    if (rect_width(format) && rect_height(format)) frame->display = format;
}

/* Fetch all pictures of a frame. PICTURE_NONE: there is no source. */
static PictureResult fetch_pictures(Frame *frame, char *why) {
    Instance *instance = frame->instance;
    PictureResult found = picture_fetch(&frame->output, instance->output, frame->time, "Output", why);
    if (found == PICTURE_NONE) snprintf(why, WHY_ROOM, "Output: the host gave no image to fill");
    if (found != PICTURE_HERE) return PICTURE_WRONG;
    found = picture_fetch(&frame->source, instance->source, frame->time, "Source", why);
    if (found != PICTURE_HERE) return found;
    if (frame->source.channels != 4 || frame->output.channels != 4) {
        snprintf(why, WHY_ROOM, "Flowabs works on RGBA, the host gave a Source or an Output of alpha alone");
        return PICTURE_WRONG;
    }
    if (picture_fetch(&frame->mask, instance->mask, frame->time, "Mask", why) == PICTURE_WRONG) return PICTURE_WRONG;
    for (int i = 0; i < instance->effect->clip_count; i++)
        if (picture_fetch(&frame->clips[i], instance->clips[i], frame->time, instance->effect->clips[i].name, why) ==
            PICTURE_WRONG)
            return PICTURE_WRONG;
    return PICTURE_HERE;
}

/* Give all pictures back. */
static void release_pictures(Frame *frame) {
    picture_release(&frame->output);
    picture_release(&frame->source);
    picture_release(&frame->mask);
    for (int i = 0; i < MOST_CLIPS; i++) picture_release(&frame->clips[i]);
}

/* ---------------------------------------------------------------------- the request */

/* Return a place in memory rounded up. */
static size_t aligned(size_t bytes) { return (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT; }

/* Add a picture in shared memory to the request: on a window of the host, y up, the server's y goes down. Of one
   channel the server asks no name: it is "A". */
static void add_picture(
    Text *out, const Frame *frame, const Picture *picture, OfxRectI window, const Block *block, size_t offset,
    const char *colorspace, const char *channels
) {
    text_add(
        out,
        "{\"memory\": %d, \"offset\": %zu, \"width\": %d, \"height\": %d, \"channels\": \"%s\", \"dtype\": \"%s\", "
        "\"row_bytes\": %zu, \"alpha\": \"%s\", \"window\": [%d, %d], \"display\": [0, 0, %d, %d], \"colorspace\": ",
        block->number, offset, rect_width(window), rect_height(window), channels[1] ? channels : "A",
        picture->half ? "float16" : "float32", (size_t)rect_width(window) * strlen(channels) * (picture->half ? 2 : 4),
        picture->alpha, window.x1 - frame->display.x1, frame->display.y2 - window.y2, rect_width(frame->display),
        rect_height(frame->display)
    );
    text_add_string(out, colorspace);
}

/* Copy a picture into shared memory, and add it to those that are given. Its content has the same name as long as
   nothing in the block has changed: then the server need not look at it again. */
static void give_picture(
    Text *out, const Frame *frame, const Picture *picture, Block *block, size_t offset, const char *colorspace,
    const char *channels
) {
    if (picture_copy_out(picture, block->shared.bytes + offset, channels)) block->stamp++;
    add_picture(out, frame, picture, picture->bounds, block, offset, colorspace, channels);
    text_add(out, ", \"content\": \"%d.%d.%lu\"}", block->run, block->number, block->stamp);
}

/* Return the name of the colour space that the host's pixels are in. */
static const char *colorspace_of(const Frame *frame) {
    const Instance *instance = frame->instance;
    int choice = instance_int(instance, ROLE_COLORSPACE, frame->time);
    const Json *name = choice < 0 ? NULL : json_at(json_get(instance->effect->json, "colorspaces"), choice);
    return name && name->string && *name->string ? name->string
                                                 : instance_string(instance, ROLE_COLORSPACE_NAME, frame->time);
}

/* Return the name of the output that was chosen; NULL for a choice that there is not. */
static const char *output_of(const Frame *frame) {
    int choice = instance_int(frame->instance, ROLE_OUTPUT, frame->time);
    const Json *name = choice < 0 ? NULL : json_at(json_get(frame->instance->effect->json, "outputs"), choice);
    return name ? name->string : NULL;
}

/* Write the request to render, and copy the pictures to where it says. `wanted` is the window to be delivered, at
   `result` in the block. Return whether it can be asked; `why` says why not. */
static int write_request(Frame *frame, Block *block, OfxRectI wanted, size_t result, Text *out, char *why) {
    const Effect *effect = frame->instance->effect;
    const char *colorspace = colorspace_of(frame), *output = output_of(frame);
    size_t at = aligned(picture_bytes(&frame->source, frame->source.bounds));
    if (!*colorspace || !output) {
        const char *problem =
            output ? "colorspace: expected the name of a colour space, found nothing" : "output: no such choice";
        snprintf(why, WHY_ROOM, "parameter %s", problem);
        return 0;
    }
    if (block->result != result) block->stamp++; /* pictures may lie where a result was */
    block->result = result;
    text_add(out, ", \"session\": \"%s\", \"graph\": ", frame->instance->session);
    text_add_string(out, effect->graph);
    text_add(out, ", \"frame\": %d, \"scale\": ", (int)floor(frame->time + 0.5));
    text_add_number(out, frame->scale);
    text_add(out, ", \"scaled\": true, \"events\": true, \"set\": ");
    if (!instance_values(frame->instance, frame->time, out, why)) return 0;
    text_add(out, ", \"given\": {");
    text_add_string(out, effect->plate);
    text_add(out, ": ");
    give_picture(out, frame, &frame->source, block, 0, colorspace, "RGBA");
    for (int i = 0; i < effect->clip_count; i++) {
        const Picture *picture = &frame->clips[i];
        if (!picture->image) continue;
        text_add(out, ", ");
        text_add_string(out, effect->clips[i].given);
        text_add(out, ": ");
        give_picture(
            out, frame, picture, block, at, colorspace, picture->channels == 1 ? "A" : effect->clips[i].channels
        );
        at += aligned(picture_bytes(picture, picture->bounds));
    }
    text_add(out, "}, \"into\": {");
    text_add_string(out, output);
    text_add(out, ": ");
    add_picture(out, frame, &frame->output, wanted, block, result, colorspace, "RGBA");
    text_add(out, "}}");
    if (out->failed) snprintf(why, WHY_ROOM, "there is not enough memory");
    return !out->failed;
}

/* Have the server render the frame, and fill the output's window with it. */
static ServerResult filter(Frame *frame, char *why) {
    Text request = {0};
    Block *block = NULL;
    OfxRectI wanted = rect_common(frame->window, frame->source.bounds);
    size_t place = aligned(picture_bytes(&frame->source, frame->source.bounds));
    for (int i = 0; i < frame->instance->effect->clip_count; i++)
        if (frame->clips[i].image) place += aligned(picture_bytes(&frame->clips[i], frame->clips[i].bounds));
    if (!rect_width(wanted)) {
        picture_clear(&frame->output, frame->window);
        return SERVER_DONE;
    }
    ServerResult result = server_start(wants_no_more, frame, why);
    if (result == SERVER_DONE) result = server_block(place + picture_bytes(&frame->output, wanted), &block, why);
    if (result != SERVER_DONE) return result;
    if (write_request(frame, block, wanted, place, &request, why))
        result = server_call("render", &request, wants_no_more, frame, why);
    else
        result = SERVER_REFUSED;
    if (result == SERVER_DONE) {
        double mix = instance_mix(frame->instance, frame->time);
        Blend blend = {block->shared.bytes + place, wanted, &frame->source, &frame->mask, mix};
        picture_fill(&frame->output, frame->window, &blend);
    }
    server_give_back(block);
    text_free(&request);
    return result;
}

/* Where the server misses the file of a node that a clip stands for, say that the clip is to be connected. */
static void name_missing_clip(const Frame *frame, char *why) {
    const Effect *effect = frame->instance->effect;
    char start[PATH_ROOM], said[WHY_ROOM];
    for (int i = 0; i < effect->clip_count; i++) {
        snprintf(start, sizeof start, "node '%.*s'", (int)strcspn(effect->clips[i].given, "."), effect->clips[i].given);
        if (frame->clips[i].image || strncmp(why, start, strlen(start)) != 0) continue;
        snprintf(
            said, sizeof said, "connect the clip %s, or set its file in the graph: %.700s", effect->clips[i].name, why
        );
        snprintf(why, WHY_ROOM, "%s", said);
        return;
    }
}

/* ---------------------------------------------------------------------- the action */

/* Read the arguments of the action; return whether they make sense. */
static int read_arguments(Frame *frame, OfxPropertySetHandle in) {
    double scale[2] = {1, 1};
    if (host.props->propGetDouble(in, kOfxPropTime, 0, &frame->time) != kOfxStatOK || !(fabs(frame->time) < 1e9))
        return 0;
    if (host.props->propGetIntN(in, kOfxImageEffectPropRenderWindow, 4, &frame->window.x1) != kOfxStatOK) return 0;
    host.props->propGetDoubleN(in, kOfxImageEffectPropRenderScale, 2, scale);
    /* Pixels that are not square are smaller by x alone: lines are as wide as in a picture that is smaller by y. */
    frame->scale = scale[1] > 0 && scale[1] <= 1 ? scale[1] : 1;
    return 1;
}

/* Answer OfxImageEffectActionRender. A server that is lost on the way is started again, once. */
OfxStatus render(OfxImageEffectHandle handle, OfxPropertySetHandle in) {
    char why[WHY_ROOM] = "";
    Frame frame = {0};
    frame.instance = instance_of(handle);
    frame.started = seconds_now();
    if (!frame.instance) return kOfxStatErrBadHandle;
    if (!read_arguments(&frame, in)) return kOfxStatErrValue;
    ServerResult result = SERVER_REFUSED;
    PictureResult pictures = fetch_pictures(&frame, why);
    int part = pictures == PICTURE_HERE && memcmp(&frame.source.bounds, &frame.source.whole, sizeof frame.window) != 0;
    if (pictures == PICTURE_NONE) {
        picture_clear(&frame.output, frame.window);
        result = SERVER_DONE;
    } else if (pictures == PICTURE_HERE) {
        find_display(&frame);
        result = filter(&frame, why);
        if (result == SERVER_LOST) result = filter(&frame, why);
        if (result == SERVER_REFUSED) name_missing_clip(&frame, why);
    }
    release_pictures(&frame);
    if (frame.shows_progress) host.progress->progressEnd(handle);
    if (result == SERVER_STOPPED) return kOfxStatOK; /* the host does not look at the frame any more */
    if (result != SERVER_DONE) {
        say(frame.instance, kOfxMessageError, why);
        return pictures == PICTURE_WRONG ? kOfxStatErrImageFormat : kOfxStatFailed;
    }
    snprintf(why, sizeof why, "the host gave a part of the picture only: lines may not meet at its edges");
    if (part)
        say(frame.instance, kOfxMessageWarning, why);
    else
        say_nothing(frame.instance);
    return kOfxStatOK;
}

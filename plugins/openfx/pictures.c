/* Pictures in the host's memory, rows from the lowest to the highest, and in shared memory, from the top down. */

#include "pictures.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

static const char RGBA[] = "RGBA";

/* ---------------------------------------------------------------------- rectangles of pixels */

/* Return the width of a rectangle, 0 for an empty one. */
int rect_width(OfxRectI rect) { return rect.x2 > rect.x1 ? rect.x2 - rect.x1 : 0; }

/* Return the height of a rectangle, 0 for an empty one. */
int rect_height(OfxRectI rect) { return rect.y2 > rect.y1 ? rect.y2 - rect.y1 : 0; }

/* Return what two rectangles have in common; all zeros where that is nothing. */
OfxRectI rect_common(OfxRectI one, OfxRectI other) {
    OfxRectI common = {
        one.x1 > other.x1 ? one.x1 : other.x1, one.y1 > other.y1 ? one.y1 : other.y1,
        one.x2 < other.x2 ? one.x2 : other.x2, one.y2 < other.y2 ? one.y2 : other.y2
    };
    OfxRectI nothing = {0, 0, 0, 0};
    return rect_width(common) && rect_height(common) ? common : nothing;
}

/* ---------------------------------------------------------------------- from and to the host */

/* Read what an image's properties say of it; return whether it can be used, `why` says why not. */
static int read_image(Picture *picture, const char *name, char *why) {
    const OfxPropertySuiteV1 *props = host.props;
    char *depth = NULL, *components = NULL, *premultiplied = NULL;
    void *data = NULL;
    props->propGetString(picture->image, kOfxImageEffectPropPixelDepth, 0, &depth);
    props->propGetString(picture->image, kOfxImageEffectPropComponents, 0, &components);
    props->propGetString(picture->image, kOfxImageEffectPropPreMultiplication, 0, &premultiplied);
    props->propGetPointer(picture->image, kOfxImagePropData, 0, &data);
    OfxStatus rows = props->propGetInt(picture->image, kOfxImagePropRowBytes, 0, &picture->row_bytes);
    OfxStatus bounds = props->propGetIntN(picture->image, kOfxImagePropBounds, 4, &picture->bounds.x1);
    if (props->propGetIntN(picture->image, kOfxImagePropRegionOfDefinition, 4, &picture->whole.x1) != kOfxStatOK)
        picture->whole = picture->bounds;
    picture->data = data;
    picture->half = depth && strcmp(depth, kOfxBitDepthHalf) == 0;
    picture->channels = components && strcmp(components, kOfxImageComponentAlpha) == 0 ? 1 : 4;
    picture->alpha = premultiplied && strcmp(premultiplied, kOfxImageOpaque) == 0            ? "opaque"
                     : premultiplied && strcmp(premultiplied, kOfxImageUnPreMultiplied) == 0 ? "straight"
                                                                                             : "premultiplied";
    if (!depth || (!picture->half && strcmp(depth, kOfxBitDepthFloat) != 0)) {
        const char *found = depth ? depth : "pixels of no depth";
        snprintf(why, WHY_ROOM, "%s: Flowabs works on floats of 32 or 16 bits, the host gave %s", name, found);
    } else if (!components || (picture->channels == 4 && strcmp(components, kOfxImageComponentRGBA) != 0)) {
        snprintf(
            why, WHY_ROOM, "%s: Flowabs works on RGBA, the host gave %s", name, components ? components : "nothing"
        );
    } else if (!data || rows != kOfxStatOK || bounds != kOfxStatOK) {
        snprintf(why, WHY_ROOM, "%s: the host gave an image without pixels", name);
    } else {
        return 1;
    }
    return 0;
}

/* Fetch a clip's whole image. PICTURE_NONE: there is none, or it is empty; PICTURE_WRONG: `why` says what is wrong. */
PictureResult picture_fetch(Picture *picture, OfxImageClipHandle clip, OfxTime time, const char *name, char *why) {
    memset(picture, 0, sizeof *picture);
    if (!clip || host.effects->clipGetImage(clip, time, NULL, &picture->image) != kOfxStatOK || !picture->image) {
        picture->image = NULL;
        return PICTURE_NONE;
    }
    if (!read_image(picture, name, why)) {
        picture_release(picture);
        return PICTURE_WRONG;
    }
    if (rect_width(picture->bounds) && rect_height(picture->bounds)) return PICTURE_HERE;
    picture_release(picture);
    return PICTURE_NONE;
}

/* Give an image back to the host, if there is one. */
void picture_release(Picture *picture) {
    if (picture->image) host.effects->clipReleaseImage(picture->image);
    picture->image = NULL;
}

/* Return how many bytes a number has. */
static size_t number_bytes(const Picture *picture) { return picture->half ? 2 : 4; }

/* Return how many bytes the pixels of a window have, without gaps. */
size_t picture_bytes(const Picture *picture, OfxRectI window) {
    return (size_t)rect_width(window) * (size_t)rect_height(window) * (size_t)picture->channels * number_bytes(picture);
}

/* Return where the numbers of a pixel are, which has to be within the bounds. */
static unsigned char *pixel_at(const Picture *picture, int x, int y) {
    ptrdiff_t rows = (ptrdiff_t)y - picture->bounds.y1, columns = (ptrdiff_t)x - picture->bounds.x1;
    return picture->data + rows * picture->row_bytes + columns * picture->channels * (ptrdiff_t)number_bytes(picture);
}

/* Copy a row without the channels that are not wanted; return whether that changed anything. */
static int copy_channels(const Picture *picture, const unsigned char *row, unsigned char *out, const char *channels) {
    size_t number = number_bytes(picture);
    int changed = 0;
    for (int x = 0; x < rect_width(picture->bounds); x++, row += number * (size_t)picture->channels)
        for (const char *channel = channels; *channel; channel++, out += number) {
            const unsigned char *from = row + number * (size_t)(strchr(RGBA, *channel) - RGBA);
            changed |= memcmp(out, from, number) != 0;
            memcpy(out, from, number);
        }
    return changed;
}

/* Copy all pixels into shared memory, the highest row first, without gaps; return whether that changed anything there.
   `channels` are those that are wanted of RGBA; of a clip of alpha alone it is always its one channel. */
int picture_copy_out(const Picture *picture, unsigned char *shared, const char *channels) {
    int whole = picture->channels == 1 || strcmp(channels, RGBA) == 0, changed = 0;
    size_t count = whole ? (size_t)picture->channels : strlen(channels);
    size_t row = (size_t)rect_width(picture->bounds) * count * number_bytes(picture);
    for (int y = picture->bounds.y2 - 1; y >= picture->bounds.y1; y--, shared += row) {
        const unsigned char *from = pixel_at(picture, picture->bounds.x1, y);
        if (!whole) {
            changed |= copy_channels(picture, from, shared, channels);
        } else if (memcmp(shared, from, row) != 0) { /* of another picture this ends at once */
            memcpy(shared, from, row);
            changed = 1;
        }
    }
    return changed;
}

/* Make a window of an image black and transparent. */
void picture_clear(const Picture *picture, OfxRectI window) {
    OfxRectI common = rect_common(window, picture->bounds);
    size_t row = (size_t)rect_width(common) * (size_t)picture->channels * number_bytes(picture);
    for (int y = common.y1; y < common.y2; y++) memset(pixel_at(picture, common.x1, y), 0, row);
}

/* ---------------------------------------------------------------------- numbers */

/* Return a number of 16 bits as one of 32. */
static float from_half(uint16_t half) {
    uint32_t sign = (uint32_t)(half & 0x8000) << 16, exponent = (half >> 10) & 31, fraction = half & 0x3FF, bits;
    if (exponent == 31) {
        bits = sign | 0x7F800000 | fraction << 13;
    } else if (exponent) {
        bits = sign | (exponent + 112) << 23 | fraction << 13;
    } else { /* below the smallest normal number */
        float small = (float)fraction * (1.0f / 16777216);
        memcpy(&bits, &small, 4);
        bits |= sign;
    }
    float number;
    memcpy(&number, &bits, 4);
    return number;
}

/* Return a number of 32 bits as the nearest of 16; halfway, the even one. Beyond 65504 it is infinite. */
static uint16_t to_half(float number) {
    uint32_t bits;
    memcpy(&bits, &number, 4);
    uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);
    bits &= 0x7FFFFFFF;
    if (bits > 0x7F800000) return sign | 0x7E00;  /* NaN */
    if (bits >= 0x477FF000) return sign | 0x7C00; /* 65520 and above */
    if (bits >= 0x38800000) {
        bits += 0xFFF + (bits >> 13 & 1);
        return sign | (uint16_t)((bits - 0x38000000) >> 13);
    }
    float shifted = number < 0 ? -number : number;
    shifted += 0.5f; /* brings steps of 2^-24 to the last bit: the addition rounds */
    memcpy(&bits, &shifted, 4);
    return sign | (uint16_t)(bits - 0x3F000000);
}

/* Return one of a pixel's numbers, by its place. */
static float read_number(const unsigned char *pixel, int half, int place) {
    uint16_t small;
    float number;
    if (half) {
        memcpy(&small, pixel + 2 * place, 2);
        return from_half(small);
    }
    memcpy(&number, pixel + 4 * place, 4);
    return number;
}

/* Write one of a pixel's numbers. */
static void write_number(unsigned char *pixel, int half, int place, float number) {
    uint16_t small = half ? to_half(number) : 0;
    if (half)
        memcpy(pixel + 2 * place, &small, 2);
    else
        memcpy(pixel + 4 * place, &number, 4);
}

/* ---------------------------------------------------------------------- the result over the source */

/* Return how much of the result goes over a pixel: mask, within 0 and 1, times mix. Outside of a mask it is 0. */
static double amount_at(const Blend *blend, int x, int y) {
    const Picture *mask = blend->mask;
    if (!mask->image) return blend->mix;
    if (x < mask->bounds.x1 || x >= mask->bounds.x2 || y < mask->bounds.y1 || y >= mask->bounds.y2) return 0;
    float value = read_number(pixel_at(mask, x, y), mask->half, mask->channels - 1); /* alpha is the last */
    return blend->mix * (value > 1 ? 1 : value > 0 ? value : 0);
}

/* Lay one pixel of the result over the source's; where all or nothing of it counts, the bits stay what they are. */
static void
blend_pixel(unsigned char *out, const Picture *output, const unsigned char *result, const Blend *blend, int x, int y) {
    const Picture *source = blend->source;
    OfxRectI box = source->bounds;
    int inside = x >= box.x1 && x < box.x2 && y >= box.y1 && y < box.y2;
    const unsigned char *below = inside ? pixel_at(source, x, y) : NULL;
    double amount = amount_at(blend, x, y);
    for (int i = 0; i < output->channels; i++) {
        float over = read_number(result, output->half, i);
        float under = below ? read_number(below, source->half, i) : 0;
        float mixed = amount >= 1 ? over : amount <= 0 ? under : (float)(under + ((double)over - under) * amount);
        write_number(out, output->half, i, mixed);
    }
}

/* Fill a window of the output with the result, laid over the source by mask times mix. What the result does not cover
   becomes black and transparent. The result has the output's kind of numbers. */
void picture_fill(const Picture *output, OfxRectI window, const Blend *blend) {
    OfxRectI common = rect_common(rect_common(window, blend->window), output->bounds);
    size_t pixel = (size_t)output->channels * number_bytes(output);
    size_t row = (size_t)rect_width(blend->window) * pixel;
    int as_it_is = blend->mix >= 1 && !blend->mask->image;
    if (memcmp(&common, &window, sizeof common) != 0) picture_clear(output, window);
    for (int y = common.y1; y < common.y2; y++) {
        const unsigned char *from =
            blend->result + (size_t)(blend->window.y2 - 1 - y) * row + (size_t)(common.x1 - blend->window.x1) * pixel;
        unsigned char *to = pixel_at(output, common.x1, y);
        if (as_it_is) {
            memcpy(to, from, (size_t)rect_width(common) * pixel);
            continue;
        }
        for (int x = common.x1; x < common.x2; x++, from += pixel, to += pixel)
            blend_pixel(to, output, from, blend, x, y);
    }
}

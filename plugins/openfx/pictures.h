/* Pictures in the host's memory, rows from the lowest to the highest, and in shared memory, from the top down. */

#ifndef FLOWABS_PICTURES_H
#define FLOWABS_PICTURES_H

#include "effects.h"

/* An image that the host has handed over. It is given back with picture_release. */
typedef struct Picture {
    OfxPropertySetHandle image; /* NULL: there is none, and nothing to give back */
    unsigned char *data;        /* of the pixel at bounds.x1, bounds.y1 */
    OfxRectI bounds;            /* of the pixels that are there, y up */
    OfxRectI whole;             /* of all pixels that the picture has */
    int row_bytes;              /* from a row to the one above it; may be negative */
    int half;                   /* 16 bits a number, else 32 */
    int channels;               /* 4, or 1 for alpha alone */
    const char *alpha;          /* in the words of the server */
} Picture;

typedef enum { PICTURE_HERE, PICTURE_NONE, PICTURE_WRONG } PictureResult;

PictureResult picture_fetch(Picture *picture, OfxImageClipHandle clip, OfxTime time, const char *name, char *why);
void picture_release(Picture *picture);

int rect_width(OfxRectI rect);
int rect_height(OfxRectI rect);
OfxRectI rect_common(OfxRectI one, OfxRectI other);

size_t picture_bytes(const Picture *picture, OfxRectI window);
int picture_copy_out(const Picture *picture, unsigned char *shared, const char *channels);
void picture_clear(const Picture *picture, OfxRectI window);

/* What is laid over what: the result of the server, on its window, over the source, by mask times mix. */
typedef struct Blend {
    const unsigned char *result;
    OfxRectI window;
    const Picture *source;
    const Picture *mask; /* without an image: 1 everywhere */
    double mix;
} Blend;

void picture_fill(const Picture *output, OfxRectI window, const Blend *blend);

#endif

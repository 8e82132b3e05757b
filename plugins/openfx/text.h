/* A text that grows, and JSON written into it. */

#ifndef FLOWABS_TEXT_H
#define FLOWABS_TEXT_H

#include <stddef.h>

typedef struct Text {
    char *chars; /* always ends in 0, except before the first addition: then NULL */
    size_t length;
    size_t room;
    int failed; /* there was not enough memory: the text is not whole */
} Text;

void text_add(Text *text, const char *format, ...);
void text_add_string(Text *text, const char *string);
void text_add_number(Text *text, double number);
void text_free(Text *text);

#endif

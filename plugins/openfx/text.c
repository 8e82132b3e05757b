/* A text that grows, and JSON written into it.

   A host may have set a locale whose numbers have a comma; JSON's have a point. */

#include "text.h"

#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Make room for `more` characters and the 0 at the end; return 0 where there is no memory. */
static int make_room(Text *text, size_t more) {
    if (text->failed) return 0;
    if (text->length + more + 1 > text->room) {
        size_t room = (text->length + more + 1) * 2;
        char *chars = realloc(text->chars, room);
        if (!chars) {
            text->failed = 1;
            return 0;
        }
        text->chars = chars;
        text->room = room;
    }
    return 1;
}

/* Add what printf would print. */
void text_add(Text *text, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (length < 0 || !make_room(text, (size_t)length)) return;
    va_start(arguments, format);
    vsnprintf(text->chars + text->length, (size_t)length + 1, format, arguments);
    va_end(arguments);
    text->length += (size_t)length;
}

/* Add a string as JSON, in quotes. */
void text_add_string(Text *text, const char *string) {
    text_add(text, "\"");
    for (; *string; string++) {
        unsigned char c = (unsigned char)*string;
        if (c == '"' || c == '\\')
            text_add(text, "\\%c", c);
        else if (c < 0x20)
            text_add(text, "\\u%04x", c);
        else
            text_add(text, "%c", c);
    }
    text_add(text, "\"");
}

/* Add a number as JSON, with as many digits as give the same bits again; null for NaN and infinity. */
void text_add_number(Text *text, double number) {
    if (!isfinite(number)) {
        text_add(text, "null");
        return;
    }
    char digits[64];
    snprintf(digits, sizeof digits, "%.17g", number);
    const char *comma = localeconv()->decimal_point, *found = strstr(digits, comma);
    if (found && strcmp(comma, ".") != 0)
        text_add(text, "%.*s.%s", (int)(found - digits), digits, found + strlen(comma));
    else
        text_add(text, "%s", digits);
}

/* Let go of a text, which is empty then. */
void text_free(Text *text) {
    free(text->chars);
    memset(text, 0, sizeof *text);
}

/* JSON, read into a tree.

   A host may have set a locale whose numbers have a comma; JSON's have a point. */

#include "json.h"

#include <locale.h>
#include <stdlib.h>
#include <string.h>

enum { DEPTH = 32 }; /* how deep lists and objects may lie in one another */

typedef struct Reader {
    const char *at, *end;
} Reader;

static Json *read_value(Reader *reader, int depth);

/* Step over blanks. */
static void skip_blanks(Reader *reader) {
    while (reader->at < reader->end && strchr(" \t\r\n", *reader->at) && *reader->at) reader->at++;
}

/* Step over `c` if it comes next, and return whether it did. */
static int take(Reader *reader, char c) {
    skip_blanks(reader);
    if (reader->at >= reader->end || *reader->at != c) return 0;
    reader->at++;
    return 1;
}

/* Step over a word such as "true" if it comes next, and return whether it did. */
static int take_word(Reader *reader, const char *word) {
    size_t length = strlen(word);
    if ((size_t)(reader->end - reader->at) < length || memcmp(reader->at, word, length) != 0) return 0;
    reader->at += length;
    return 1;
}

/* Read four hexadecimal digits; return -1 where there are none. */
static long read_hex(Reader *reader) {
    long code = 0;
    if (reader->end - reader->at < 4) return -1;
    for (int i = 0; i < 4; i++) {
        char c = *reader->at++;
        int digit = c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c - 'A' + 10;
        if (digit < 0 || digit > 15) return -1;
        code = code * 16 + digit;
    }
    return code;
}

/* Read what follows "\u", two of them for a character above U+FFFF, and write it at `out` as UTF-8: at most four bytes.
   Return how many; 0 for what is no character. */
static int read_escaped(Reader *reader, char *out) {
    long code = read_hex(reader);
    if (code >= 0xD800 && code < 0xDC00 && take_word(reader, "\\u")) {
        long low = read_hex(reader);
        if (low < 0xDC00 || low > 0xDFFF) return 0;
        code = 0x10000 + (code - 0xD800) * 0x400 + (low - 0xDC00);
    }
    if (code < 1 || (code >= 0xD800 && code <= 0xDFFF)) return 0;
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    out[0] = (char)((more == 1 ? 0xC0 : more == 2 ? 0xE0 : 0xF0) | (code >> (6 * more)));
    for (int i = 1; i <= more; i++) out[i] = (char)(0x80 | ((code >> (6 * (more - i))) & 0x3F));
    return more + 1;
}

/* Read a string, whose first quote has been stepped over. Return new memory, or NULL. */
static char *read_string(Reader *reader) {
    const char *stop = reader->at;
    while (stop < reader->end && *stop != '"') stop += *stop == '\\' && stop + 1 < reader->end ? 2 : 1;
    if (stop >= reader->end) return NULL;
    char *string = malloc((size_t)(stop - reader->at) + 1), *out = string; /* an escape is longer than what it means */
    while (string && reader->at < stop) {
        char c = *reader->at++;
        if (c != '\\') {
            *out++ = c;
            continue;
        }
        c = *reader->at++;
        const char *found = strchr("nrtbf", c);
        int count = c == 'u' ? read_escaped(reader, out) : 1;
        if (c != 'u') *out = found ? "\n\r\t\b\f"[found - "nrtbf"] : c;
        if (!count || reader->at > stop) {
            free(string);
            return NULL;
        }
        out += count;
    }
    if (string) *out = 0;
    reader->at = stop + 1;
    return string;
}

/* Read a number into `json`; return whether there is one. */
static int read_number(Reader *reader, Json *json) {
    char digits[64];
    size_t length = 0;
    const char *comma = localeconv()->decimal_point;
    while (reader->at < reader->end && length + strlen(comma) + 1 < sizeof digits) {
        char c = *reader->at;
        if (!c || !strchr("+-0123456789.eE", c)) break;
        if (c == '.') {
            memcpy(digits + length, comma, strlen(comma));
            length += strlen(comma);
        } else {
            digits[length++] = c;
        }
        reader->at++;
    }
    digits[length] = 0;
    char *stop;
    json->number = strtod(digits, &stop);
    return length > 0 && *stop == 0;
}

/* Read the members of a list or an object up to `close`; return whether all is well. */
static int read_members(Reader *reader, Json *json, char close, int depth) {
    Json **place = &json->first;
    if (take(reader, close)) return 1;
    do {
        char *key = NULL;
        if (json->type == JSON_OBJECT) {
            key = take(reader, '"') ? read_string(reader) : NULL;
            if (!key || !take(reader, ':')) {
                free(key);
                return 0;
            }
        }
        Json *member = read_value(reader, depth + 1);
        if (!member) {
            free(key);
            return 0;
        }
        member->key = key;
        *place = member;
        place = &member->next;
    } while (take(reader, ','));
    return take(reader, close);
}

/* Read any value; return NULL for what is none. */
static Json *read_value(Reader *reader, int depth) {
    Json *json = calloc(1, sizeof *json);
    int well = 0;
    if (!json || depth > DEPTH) {
        free(json);
        return NULL;
    }
    if (take(reader, '{')) {
        json->type = JSON_OBJECT;
        well = read_members(reader, json, '}', depth);
    } else if (take(reader, '[')) {
        json->type = JSON_LIST;
        well = read_members(reader, json, ']', depth);
    } else if (take(reader, '"')) {
        json->type = JSON_STRING;
        json->string = read_string(reader);
        well = json->string != NULL;
    } else if (take_word(reader, "true")) {
        json->type = JSON_TRUE;
        well = 1;
    } else if (take_word(reader, "false")) {
        json->type = JSON_FALSE;
        well = 1;
    } else if (take_word(reader, "null")) {
        well = 1;
    } else {
        json->type = JSON_NUMBER;
        well = read_number(reader, json);
    }
    if (!well) {
        json_free(json);
        return NULL;
    }
    return json;
}

/* Return the tree of a JSON text, to be freed by json_free; NULL for what is none, or where there is no memory. */
Json *json_read(const char *chars, size_t length) {
    Reader reader = {chars, chars + length};
    Json *json = read_value(&reader, 0);
    skip_blanks(&reader);
    if (json && reader.at != reader.end) {
        json_free(json);
        return NULL;
    }
    return json;
}

/* Let go of a tree. */
void json_free(Json *json) {
    while (json) {
        Json *next = json->next;
        json_free(json->first);
        free(json->key);
        free(json->string);
        free(json);
        json = next;
    }
}

/* ---------------------------------------------------------------------- looking into a tree */

/* Return the value of a key; NULL where there is none. */
const Json *json_get(const Json *object, const char *key) {
    const Json *member = object ? object->first : NULL;
    while (member && !(member->key && strcmp(member->key, key) == 0)) member = member->next;
    return member;
}

/* Return the string of a key, or `otherwise`. */
const char *json_string(const Json *object, const char *key, const char *otherwise) {
    const Json *found = json_get(object, key);
    return found && found->type == JSON_STRING ? found->string : otherwise;
}

/* Return the number of a key, or `otherwise`. */
double json_number(const Json *object, const char *key, double otherwise) {
    const Json *found = json_get(object, key);
    return found && found->type == JSON_NUMBER ? found->number : otherwise;
}

/* Return whether the value of a key is true. */
int json_true(const Json *object, const char *key) {
    const Json *found = json_get(object, key);
    return found && found->type == JSON_TRUE;
}

/* Return how many members a list or an object has; 0 for NULL. */
int json_count(const Json *list) {
    int count = 0;
    for (const Json *member = list ? list->first : NULL; member; member = member->next) count++;
    return count;
}

/* Return a member of a list by its place, from 0; NULL beyond the last. */
const Json *json_at(const Json *list, int index) {
    const Json *member = list ? list->first : NULL;
    while (member && index-- > 0) member = member->next;
    return member;
}

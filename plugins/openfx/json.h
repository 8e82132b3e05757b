/* JSON, read into a tree. */

#ifndef FLOWABS_JSON_H
#define FLOWABS_JSON_H

#include <stddef.h>

typedef enum { JSON_NULL, JSON_FALSE, JSON_TRUE, JSON_NUMBER, JSON_STRING, JSON_LIST, JSON_OBJECT } JsonType;

typedef struct Json {
    JsonType type;
    char *key;    /* in an object; else NULL */
    char *string; /* of JSON_STRING, UTF-8 */
    double number;
    struct Json *first; /* of a list or an object */
    struct Json *next;  /* beside this one, in the same list or object */
} Json;

Json *json_read(const char *chars, size_t length);
void json_free(Json *json);
const Json *json_get(const Json *object, const char *key);
const char *json_string(const Json *object, const char *key, const char *otherwise);
double json_number(const Json *object, const char *key, double otherwise);
int json_true(const Json *object, const char *key);
int json_count(const Json *list);
const Json *json_at(const Json *list, int index);

#endif

/* Read Contents/Resources of the bundle: effects.json, and server.txt, which says where Python is.

   Both are written by `flowabs openfx build`, so that a host which lists its plug-ins starts nothing. */

#include "effects.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server.h"

#define FORMAT "flowabs.openfx/1"

static Effect effects[MOST_EFFECTS];
static int effect_count = -1; /* not read yet */
static Json *document;        /* which the effects point into; it stays until the library goes */

/* Return the content of a file of Resources, to be freed, with a 0 at its end; NULL where it cannot be read. */
static char *read_resource(const char *name, size_t *length) {
    char path[PATH_ROOM];
    if (!library_path(path, sizeof path)) return NULL;
    for (int up = 0; up < 2; up++) { /* from Contents/Linux-x86-64/Flowabs.ofx to Contents */
        char *slash = strrchr(path, '/');
        if (!slash) return NULL;
        *slash = 0;
    }
    size_t used = strlen(path);
    snprintf(path + used, sizeof path - used, "/Resources/%s", name);
    FILE *file = fopen(path, "rb");
    Text content = {0};
    char part[4097];
    size_t count = 0;
    while (file && (count = fread(part, 1, sizeof part - 1, file)) > 0) {
        part[count] = 0;
        if (memchr(part, 0, count)) break; /* no text */
        text_add(&content, "%s", part);
    }
    if (file) fclose(file);
    if (content.failed || !content.chars) {
        fprintf(stderr, "flowabs: cannot read %s\n", path);
        text_free(&content);
        return NULL;
    }
    *length = content.length;
    return content.chars;
}

/* Read server.txt: the Python, and on a second line where it finds the package, if not by itself. */
static void read_server(void) {
    size_t length = 0;
    const char *own = getenv("FLOWABS_PYTHON");
    char *content = own && *own ? NULL : read_resource("server.txt", &length);
    char *path = content ? content + strcspn(content, "\r\n") : NULL;
    if (path && *path) {
        *path++ = 0;
        path += strspn(path, "\r\n");
        path[strcspn(path, "\r\n")] = 0;
    }
    server_configure(own && *own ? own : content && *content ? content : "python3", path ? path : "");
    free(content);
}

/* Return the place of a word in a list of words that ends in NULL, or `otherwise`. */
static int place_of(const char *word, const char *const *words, int otherwise) {
    for (int i = 0; words[i]; i++)
        if (strcmp(words[i], word) == 0) return i;
    return otherwise;
}

/* Read the parameters of an effect; return whether there is memory for them. */
static int read_params(Effect *effect) {
    static const char *const roles[] = {"knob", "output", "mix", "colorspace", "colorspace_name", NULL};
    static const char *const types[] = {"double", "int", "choice", "boolean", "rgb", "string", NULL};
    const Json *list = json_get(effect->json, "params");
    effect->params = calloc((size_t)json_count(list) + 1, sizeof *effect->params);
    for (const Json *each = effect->params && list ? list->first : NULL; each; each = each->next) {
        int type = place_of(json_string(each, "type", ""), types, -1);
        if (type < 0) continue;
        Param *param = &effect->params[effect->param_count++];
        param->json = each;
        param->name = json_string(each, "name", "");
        param->knob = json_string(each, "knob", "");
        param->role = (Role)place_of(json_string(each, "role", "knob"), roles, ROLE_KNOB);
        param->type = (ParamType)type;
    }
    return effect->params != NULL;
}

/* Read one effect; return whether it can be one. */
static int read_effect(Effect *effect, const Json *json) {
    effect->json = json;
    effect->label = json_string(json, "label", NULL);
    effect->graph = json_string(json, "graph", NULL);
    effect->plate = json_string(json, "plate", NULL);
    effect->output_count = json_count(json_get(json, "outputs"));
    const Json *clips = json_get(json, "clips");
    for (const Json *each = clips ? clips->first : NULL; each && effect->clip_count < MOST_CLIPS; each = each->next) {
        Clip *clip = &effect->clips[effect->clip_count++];
        clip->name = json_string(each, "name", "");
        clip->label = json_string(each, "label", "");
        clip->given = json_string(each, "given", "");
        clip->channels = json_string(each, "channels", "RGBA");
    }
    const char *identifier = json_string(json, "identifier", NULL);
    return identifier && effect->label && effect->graph && effect->plate && effect->output_count && read_params(effect);
}

/* Read the bundle's effects, once; return how many there are. What is wrong with the file is printed. */
int effects_load(void) {
    size_t length = 0;
    if (effect_count >= 0) return effect_count;
    effect_count = 0;
    read_server();
    char *content = read_resource("effects.json", &length);
    document = content ? json_read(content, length) : NULL;
    free(content);
    if (content && strcmp(json_string(document, "format", ""), FORMAT) != 0)
        fprintf(stderr, "flowabs: Resources/effects.json is not of the format " FORMAT ": run flowabs openfx build\n");
    else
        for (const Json *each = document ? json_at(json_get(document, "effects"), 0) : NULL; each; each = each->next)
            if (effect_count < MOST_EFFECTS && read_effect(&effects[effect_count], each)) effect_count++;
    return effect_count;
}

/* Return an effect by its place, from 0. */
const Effect *effects_get(int index) { return &effects[index]; }

/* Return the version of flowabs that wrote effects.json. */
const char *effects_version(void) { return json_string(document, "flowabs", ""); }

/* Let go of the effects when the library goes: nobody can ask for them any more. */
#if defined(__GNUC__)
__attribute__((destructor)) static void effects_free(void) {
    for (int i = 0; i < effect_count; i++) free(effects[i].params);
    json_free(document);
}
#endif

/* The plug-in as a host sees it: one effect for each graph of effects.json, and the actions that come to it.

   A host calls an effect by a function of its own, which gets no word of which effect is meant. There is therefore one
   such function for each effect that there can be; all do the same. */

#include <stdio.h>
#include <string.h>

#include "effects.h"
#include "server.h"

Suites host;
static int loaded; /* how many effects the host has loaded, and not yet unloaded */

/* Answer OfxActionLoad: fetch the host's suites. */
static OfxStatus load(void) {
    if (!host.host || !host.host->fetchSuite) return kOfxStatErrMissingHostFeature;
    host.props = host.host->fetchSuite(host.host->host, kOfxPropertySuite, 1);
    host.effects = host.host->fetchSuite(host.host->host, kOfxImageEffectSuite, 1);
    host.params = host.host->fetchSuite(host.host->host, kOfxParameterSuite, 1);
    host.messages = host.host->fetchSuite(host.host->host, kOfxMessageSuite, 2);
    host.message = host.messages ? (const OfxMessageSuiteV1 *)host.messages /* begins the same */
                                 : host.host->fetchSuite(host.host->host, kOfxMessageSuite, 1);
    host.progress = host.host->fetchSuite(host.host->host, kOfxProgressSuite, 1);
    if (!host.props || !host.effects || !host.params) {
        const char *missing = !host.props     ? kOfxPropertySuite
                              : !host.effects ? kOfxImageEffectSuite
                                              : kOfxParameterSuite;
        fprintf(stderr, "flowabs: this host has no %s, version 1\n", missing);
        return kOfxStatErrMissingHostFeature;
    }
    loaded++;
    return kOfxStatOK;
}

/* Answer OfxActionUnload: the server ends with the last effect. */
static OfxStatus unload(void) {
    if (loaded > 0 && --loaded == 0) {
        server_end();
        server_purge();
    }
    return kOfxStatOK;
}

/* Answer an action that comes to an effect. Before OfxActionLoad nothing can be asked. */
static OfxStatus
answer(int index, const char *action, const void *handle, OfxPropertySetHandle in, OfxPropertySetHandle out) {
    const Effect *effect = effects_get(index);
    OfxImageEffectHandle own = (OfxImageEffectHandle)handle;
    if (strcmp(action, kOfxActionLoad) == 0) return load();
    if (strcmp(action, kOfxActionUnload) == 0) return unload();
    if (!loaded) return kOfxStatFailed;
    if (strcmp(action, kOfxActionDescribe) == 0) return describe(effect, own);
    if (strcmp(action, kOfxImageEffectActionDescribeInContext) == 0) return describe_in_context(effect, own);
    if (strcmp(action, kOfxActionCreateInstance) == 0) return create_instance(effect, own);
    if (strcmp(action, kOfxActionDestroyInstance) == 0) return destroy_instance(own);
    if (strcmp(action, kOfxActionPurgeCaches) == 0) return purge_caches(own);
    if (strcmp(action, kOfxImageEffectActionGetRegionOfDefinition) == 0) return region_of_definition(own, in, out);
    if (strcmp(action, kOfxImageEffectActionGetRegionsOfInterest) == 0) return regions_of_interest(own, in, out);
    if (strcmp(action, kOfxImageEffectActionGetClipPreferences) == 0) return clip_preferences(own, out);
    if (strcmp(action, kOfxImageEffectActionIsIdentity) == 0) return is_identity(own, in, out);
    if (strcmp(action, kOfxImageEffectActionRender) == 0) return render(own, in);
    return kOfxStatReplyDefault;
}

/* Keep the host's structure: the first call of all, the same for every effect. */
static void set_host(OfxHost *structure) { host.host = structure; }

/* ---- one entry for each effect: entry_00 to entry_FF ---- */

/* clang-format off */
#define ENTRY(n)                                                                                                  \
    static OfxStatus entry_##n(const char *a, const void *h, OfxPropertySetHandle in, OfxPropertySetHandle out) { \
        return answer(0x##n, a, h, in, out);                                                                      \
    }
#define NAME(n) entry_##n,
#define SIXTEEN(X, d) X(d##0) X(d##1) X(d##2) X(d##3) X(d##4) X(d##5) X(d##6) X(d##7) \
                      X(d##8) X(d##9) X(d##A) X(d##B) X(d##C) X(d##D) X(d##E) X(d##F)
#define ALL(X) SIXTEEN(X, 0) SIXTEEN(X, 1) SIXTEEN(X, 2) SIXTEEN(X, 3) SIXTEEN(X, 4) SIXTEEN(X, 5) \
               SIXTEEN(X, 6) SIXTEEN(X, 7) SIXTEEN(X, 8) SIXTEEN(X, 9) SIXTEEN(X, A) SIXTEEN(X, B) \
               SIXTEEN(X, C) SIXTEEN(X, D) SIXTEEN(X, E) SIXTEEN(X, F)
/* clang-format on */

ALL(ENTRY)
static OfxPluginEntryPoint *const ENTRIES[MOST_EFFECTS] = {ALL(NAME)};

/* Return how many effects there are. */
OfxExport int OfxGetNumberOfPlugins(void) { return effects_load(); }

/* Return an effect by its place, from 0; NULL beyond the last. */
OfxExport OfxPlugin *OfxGetPlugin(int nth) {
    static OfxPlugin plugins[MOST_EFFECTS];
    if (nth < 0 || nth >= effects_load()) return NULL;
    OfxPlugin *plugin = &plugins[nth];
    plugin->pluginApi = kOfxImageEffectPluginApi;
    plugin->apiVersion = kOfxImageEffectPluginApiVersion;
    plugin->pluginIdentifier = json_string(effects_get(nth)->json, "identifier", "");
    plugin->pluginVersionMajor = 1;
    plugin->pluginVersionMinor = 0;
    plugin->setHost = set_host;
    plugin->mainEntry = ENTRIES[nth];
    return plugin;
}

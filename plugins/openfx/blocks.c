/* Memory that the server has mapped: blocks, which frames take and give back. */

#include "server.h"

#include <stdio.h>
#include <stdlib.h>

enum { FREE_BLOCKS = 3 }; /* how many are kept that nobody uses */

static Lock guard = LOCK_START; /* of what follows; held for moments */
static Block *blocks;
static int last_number;

/* Take out of the list, under the guard, a block that nobody uses: one of an older run, or the first of too many. */
static Block *superfluous_block(int keep, int run) {
    int count = 0;
    for (Block **place = &blocks; *place; place = &(*place)->next) {
        Block *block = *place;
        if (block->used) continue;
        if (block->run == run && ++count <= keep) continue;
        *place = block->next;
        return block;
    }
    return NULL;
}

/* Let go of blocks that nobody uses, but for `keep` of them, here and in the server. */
static void drop_blocks(int keep) {
    for (;;) {
        char why[WHY_ROOM];
        int run = server_run();
        lock(&guard);
        Block *block = superfluous_block(keep, run);
        unlock(&guard);
        if (!block) return;
        if (run && block->run == run) {
            Text rest = {0};
            text_add(&rest, ", \"memory\": %d", block->number);
            server_call("unmap", &rest, NULL, NULL, why);
            text_free(&rest);
        }
        shared_free(&block->shared);
        free(block);
    }
}

/* Find memory of at least this size that the server has mapped; the caller gives it back. */
ServerResult server_block(size_t size, Block **found, char *why) {
    int run = server_run();
    lock(&guard);
    for (Block *block = blocks; block; block = block->next) {
        if (block->used || block->run != run || block->shared.size < size) continue;
        block->used = 1;
        *found = block;
        unlock(&guard);
        return SERVER_DONE;
    }
    unlock(&guard);
    drop_blocks(0); /* the size of pictures has changed, or more are at work at once than ever */

    Block *block = calloc(1, sizeof *block);
    if (!block || !shared_make(&block->shared, size)) {
        free(block);
        snprintf(why, WHY_ROOM, "there is no room for a picture of %zu MB in shared memory", size >> 20);
        return SERVER_REFUSED;
    }
    lock(&guard);
    block->number = ++last_number;
    block->run = run;
    block->used = 1;
    unlock(&guard);
    Text rest = {0};
    text_add(&rest, ", \"memory\": %d, \"bytes\": %zu, \"" SHARED_NAME_KEY "\": ", block->number, size);
    text_add_string(&rest, block->shared.name);
    ServerResult result = server_call("map", &rest, NULL, NULL, why);
    text_free(&rest);
    shared_forget_name(&block->shared);
    if (result != SERVER_DONE) {
        shared_free(&block->shared);
        free(block);
        return result;
    }
    lock(&guard);
    block->next = blocks;
    blocks = block;
    unlock(&guard);
    *found = block;
    return SERVER_DONE;
}

/* Give back memory that server_block found. */
void server_give_back(Block *block) {
    lock(&guard);
    block->used = 0;
    unlock(&guard);
    drop_blocks(FREE_BLOCKS);
}

/* Let go of memory that nobody uses, here and in the server. */
void server_purge(void) { drop_blocks(0); }

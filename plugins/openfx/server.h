/* The link to `flowabs serve`: one process for all effects of a host, started when the first frame is rendered.

   The messages are described in docs/serve.md. Any thread may call; calls of several threads are at work at once. */

#ifndef FLOWABS_SERVER_H
#define FLOWABS_SERVER_H

#include "platform.h"
#include "text.h"

typedef enum {
    SERVER_DONE,    /* the answer says ok */
    SERVER_REFUSED, /* the answer is an error, described in words */
    SERVER_STOPPED, /* the one who waited did not want to wait any longer */
    SERVER_LOST,    /* the server ended, or said nothing for too long; another try starts a new one */
    SERVER_MISSING  /* the server cannot be started */
} ServerResult;

/* Memory that the server has mapped, by its number. */
typedef struct Block {
    Shared shared;
    int number;
    int run; /* which start of the server knows it */
    int used;
    size_t result;       /* where the server was last told to write */
    unsigned long stamp; /* counts the changes of what lies before that place */
    struct Block *next;
} Block;

/* Whoever waits for an answer is asked again and again whether to go on, and told how much is done, from 0 to 1.
   Returns 0 to go on, 1 to have the request cancelled. */
typedef int (*Ask)(void *asked, double done);

void server_configure(const char *python, const char *python_path);
ServerResult server_start(Ask ask, void *asked, char *why);
ServerResult server_call(const char *what, const Text *rest, Ask ask, void *asked, char *why);
int server_run(void);
void server_forget(const char *session);
void server_end(void);

/* blocks.c */
ServerResult server_block(size_t size, Block **block, char *why);
void server_give_back(Block *block);
void server_purge(void);

#endif

/* The link to `flowabs serve`: one process for all effects of a host, started when the first frame is rendered.

   One thread receives; each caller sends for itself and waits for the answer with its number. A server that has said
   nothing for a while is asked to say hello; if it stays silent it is ended, and counts as lost. */

#include "server.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json.h"

static const unsigned char MAGIC[8] = {'F', 'L', 'A', 'B', 'S', '1', 0, 0};

enum { HEADER = 16, LONGEST = 8 << 20, PROTOCOL = 1, LOOK = 10 };

/* Seconds; LOOK is in milliseconds: how often who waits is asked. A server's first words take a while: Python loads its
 * libraries. */
static const double UNTIL_HELLO = 5, UNTIL_LOST = 60, UNTIL_GREETING = 120, TO_SEND = 20, TO_END = 5;

/* A request that waits for its answer. */
typedef struct Call {
    int id;
    double done; /* how much of it, from 0 to 1 */
    Json *answer;
    struct Call *next;
} Call;

/* All that follows is read and written under `guard`, except while only one thread can know of it. */
static struct {
    Lock guard;    /* held for moments */
    Lock starting; /* held by the one who starts or ends the server */
    Lock sending;  /* held while a message is sent: messages stay whole */
    Signal news;
    char python[PATH_ROOM], python_path[PATH_ROOM];
    Child child;
    Thread receiver;
    long owner;  /* the process that started the server: a copy of the host made by fork leaves it alone */
    int there;   /* a child was started, and not yet cleared away */
    int alive;   /* the receiver is at work */
    int greeted; /* the first message came, and fits */
    int run;     /* counts the starts */
    int last_id;
    double heard; /* when the last message came */
    double asked; /* when the last hello was sent */
    Call *calls;
    char refusal[WHY_ROOM]; /* what was wrong with the first message */
} link = {.guard = LOCK_START, .starting = LOCK_START, .sending = LOCK_START, .news = SIGNAL_START};

/* Say which Python is to be started, and where it finds modules beside its own ("" is nowhere else). */
void server_configure(const char *python, const char *python_path) {
    snprintf(link.python, sizeof link.python, "%s", python);
    snprintf(link.python_path, sizeof link.python_path, "%s", python_path);
}

/* Return how many seconds of silence make a server a lost one; tests have no time for the usual. */
static double patience(double usual) {
    const char *other = getenv("FLOWABS_OPENFX_PATIENCE");
    double seconds = other ? atof(other) : 0;
    return seconds > 0 ? seconds : usual;
}

/* ---------------------------------------------------------------------- receiving */

/* Return the number in four bytes, the lowest first. */
static size_t number_of(const unsigned char *bytes) {
    return (size_t)bytes[0] | (size_t)bytes[1] << 8 | (size_t)bytes[2] << 16 | (size_t)bytes[3] << 24;
}

/* Receive a message, to be freed by json_free; return NULL where the server ended or what it says makes no sense. */
static Json *receive(Child *child) {
    unsigned char header[HEADER], scrap[4096];
    if (!child_receive(child, header, HEADER) || memcmp(header, MAGIC, sizeof MAGIC) != 0) return NULL;
    size_t length = number_of(header + 8);
    char *chars = length <= LONGEST ? malloc(length + 1) : NULL;
    Json *message = chars && child_receive(child, chars, length) ? json_read(chars, length) : NULL;
    free(chars);
    double payload = message ? json_number(message, "payload", 0) : 0; /* pictures come in shared memory, not here */
    while (message && payload > 0) {
        size_t part = payload < (double)sizeof scrap ? (size_t)payload : sizeof scrap;
        if (!child_receive(child, scrap, part)) {
            json_free(message);
            return NULL;
        }
        payload -= (double)part;
    }
    return message;
}

/* Hand a message to the call that it is for; under the guard. Takes the message. */
static void deliver(Json *message) {
    const Json *id = json_get(message, "id"), *event = json_get(message, "event");
    if (!id || id->type != JSON_NUMBER) { /* the first message, or what the server says before it hangs up */
        int protocol = (int)json_number(message, "protocol", -1);
        const char *error = json_string(json_get(message, "error"), "message", NULL);
        if (protocol == PROTOCOL)
            link.greeted = 1;
        else if (error)
            snprintf(link.refusal, sizeof link.refusal, "%s", error);
        else
            snprintf(
                link.refusal, sizeof link.refusal, "it speaks protocol %d, this plug-in %d: run flowabs openfx build",
                protocol, PROTOCOL
            );
        json_free(message);
        return;
    }
    Call *call = link.calls;
    while (call && call->id != (int)id->number) call = call->next;
    if (call && !event && !call->answer) {
        call->answer = message;
        return;
    }
    if (call && event) call->done = json_number(event, "progress", call->done);
    json_free(message);
}

/* Receive messages until the server ends: the work of the receiving thread. */
static void receive_all(void) {
    Json *message;
    while ((message = receive(&link.child)) != NULL) {
        lock(&link.guard);
        link.heard = seconds_now();
        deliver(message);
        int wrong = *link.refusal;
        wake_all(&link.news);
        unlock(&link.guard);
        if (wrong) break;
    }
    lock(&link.guard);
    link.alive = 0;
    wake_all(&link.news);
    unlock(&link.guard);
}

/* ---------------------------------------------------------------------- sending */

/* Send a message to a start of the server; return whether it is on its way. */
static int send_message(int run, const char *chars, size_t length) {
    unsigned char header[HEADER] = {0};
    memcpy(header, MAGIC, sizeof MAGIC);
    for (int i = 0; i < 4; i++) header[8 + i] = (unsigned char)(length >> (8 * i));
    double seconds = patience(TO_SEND);
    lock(&link.sending);
    int there = link.there && link.run == run;
    int sent =
        there && child_send(&link.child, header, HEADER, seconds) && child_send(&link.child, chars, length, seconds);
    unlock(&link.sending);
    return sent;
}

/* Send {"id": id, "do": what, rest}; `rest` is members of an object, each with a comma before it. */
static int send_request(int run, int id, const char *what, const Text *rest) {
    Text message = {0};
    text_add(&message, "{\"id\": %d, \"do\": \"%s\"%s}", id, what, rest && rest->chars ? rest->chars : "");
    int sent = !message.failed && !(rest && rest->failed) && send_message(run, message.chars, message.length);
    text_free(&message);
    return sent;
}

/* ---------------------------------------------------------------------- starting and ending */

/* Clear away a server that has ended, or is to end now; under `starting`. */
static void clear_away(double seconds) {
    if (!link.there) return;
    child_hang_up(&link.child);
    thread_join(link.receiver);
    lock(&link.sending); /* nobody sends to what is closed here */
    child_end(&link.child, seconds);
    link.there = 0;
    unlock(&link.sending);
}

/* Write why the server cannot be used, and the command that mends it. */
static ServerResult missing(char *why, const char *reason) {
    snprintf(
        why, WHY_ROOM,
        "Flowabs needs its Python, and cannot start it: %.200s -m flowabs_nodes serve: %.300s. "
        "Install it with: %.200s -m pip install flowabs-nodes (FLOWABS_PYTHON names another Python)",
        link.python, reason, link.python
    );
    return SERVER_MISSING;
}

/* Start the process and the thread that receives; under `starting`. Return whether they run. */
static int launch(char *reason) {
    const char *words[] = {link.python, "-P", "-m", "flowabs_nodes", "serve", NULL};
    Child child;
    if (!child_start(&child, words, link.python_path, reason)) return 0;
    lock(&link.sending);
    lock(&link.guard);
    link.child = child;
    link.there = link.alive = 1;
    link.greeted = 0;
    link.run++;
    link.owner = process_id();
    link.heard = link.asked = seconds_now();
    *link.refusal = 0;
    unlock(&link.guard);
    unlock(&link.sending);
    if (thread_start(&link.receiver, receive_all)) return 1;
    child_kill(&link.child);
    child_end(&link.child, 1);
    link.there = link.alive = 0;
    snprintf(reason, WHY_ROOM, "no thread can be started");
    return 0;
}

/* Wait for the first message of a server that was started. */
static ServerResult wait_for_greeting(Ask ask, void *asked, char *why) {
    char reason[WHY_ROOM];
    double until = seconds_now() + patience(UNTIL_GREETING);
    int stop = 0;
    lock(&link.guard);
    while (link.alive && !link.greeted && !*link.refusal && !stop && seconds_now() < until) {
        wait_for(&link.news, &link.guard, LOOK);
        unlock(&link.guard);
        stop = ask(asked, 0);
        lock(&link.guard);
    }
    int greeted = link.greeted && link.alive, alive = link.alive;
    snprintf(
        reason, sizeof reason, "%s",
        *link.refusal ? link.refusal
        : alive       ? "it does not answer"
                      : "it ended at once"
    );
    unlock(&link.guard);
    if (greeted) return SERVER_DONE;
    if (stop) return SERVER_STOPPED; /* it goes on starting, for the next frame */
    if (alive) child_kill(&link.child);
    clear_away(1);
    return missing(why, reason);
}

/* Start the server unless it is there, and wait for its first message. `why` has room for WHY_ROOM characters. */
ServerResult server_start(Ask ask, void *asked, char *why) {
    char reason[WHY_ROOM] = "";
    lock(&link.starting);
    if (link.there && link.owner != process_id()) link.there = link.alive = 0; /* that one is our parent's */
    lock(&link.guard);
    int alive = link.there && link.alive;
    unlock(&link.guard);
    if (!alive) clear_away(0);
    ServerResult result = alive || launch(reason) ? wait_for_greeting(ask, asked, why) : missing(why, reason);
    unlock(&link.starting);
    return result;
}

/* Have the server end, and wait until it has. */
void server_end(void) {
    lock(&link.starting);
    if (link.there && link.owner == process_id()) {
        send_request(link.run, 0, "stop", NULL);
        clear_away(patience(TO_END));
    }
    link.there = link.alive = 0;
    unlock(&link.starting);
}

/* ---------------------------------------------------------------------- calling */

/* Add words, and the mark behind them, if there are any. */
static void add_words(Text *out, const char *before, const char *words, const char *after) {
    if (*words) text_add(out, "%s%s%s", before, words, after);
}

/* Add one of the problems of a graph: of a knob that the host has set, its name is enough. */
static void add_problem(Text *out, const Json *problem) {
    const char *place = json_string(problem, "pointer", ""), *set = "--set ";
    int knob = strncmp(place, set, strlen(set)) == 0;
    add_words(out, knob ? "parameter " : "", knob ? place + strlen(set) : place, ": ");
    text_add(out, "expected %s, found ", json_string(problem, "expected", "something else"));
    text_add(out, "%s", json_string(problem, "found", "something"));
    add_words(out, " (", json_string(problem, "hint", ""), ")");
}

/* Write an error that the server answered with as one text: where it happened, what, and the hint. */
static void describe_error(const Json *answer, char *why) {
    const Json *error = json_get(answer, "error"), *problems = json_at(json_get(error, "problems"), 0);
    const char *message = json_string(error, "message", "the server gave no reason");
    const char *file = json_string(error, "file", ""), *parameter = json_string(error, "parameter", "");
    int of_knob = strncmp(json_string(problems, "pointer", ""), "--set ", 6) == 0;
    Text out = {0};
    if (!of_knob && !strstr(message, file)) add_words(&out, "", file, ": ");
    add_words(&out, "node '", json_string(error, "node", ""), "': ");
    if (strncmp(message, parameter, strlen(parameter)) != 0) add_words(&out, "parameter ", parameter, ": ");
    if (!problems) text_add(&out, "%s", message);
    for (const Json *problem = problems; problem; problem = problem->next) {
        if (problem != problems) text_add(&out, "; ");
        add_problem(&out, problem);
    }
    add_words(&out, " (", json_string(error, "hint", ""), ")");
    snprintf(why, WHY_ROOM, "%s", out.failed ? "there is not enough memory" : out.chars);
    text_free(&out);
}

/* Ask a server for a sign of life that has said nothing for a while, and end it if it gives none; under the guard. */
static void see_that_it_lives(void) {
    int run = link.run;
    double now = seconds_now(), lost = patience(UNTIL_LOST), hello = UNTIL_HELLO < lost / 4 ? UNTIL_HELLO : lost / 4;
    if (now - link.heard > lost) {
        child_kill(&link.child);
    } else if (now - link.heard > hello && now - link.asked > hello) {
        link.asked = now;
        unlock(&link.guard);
        send_request(run, 0, "hello", NULL);
        lock(&link.guard);
    }
}

/* Send a request and wait for its answer; `why` says in words what the server answered, or what became of it. */
ServerResult server_call(const char *what, const Text *rest, Ask ask, void *asked, char *why) {
    Call call = {0};
    int cancelled = 0;
    lock(&link.guard);
    if (!link.alive) {
        unlock(&link.guard);
        snprintf(why, WHY_ROOM, "Flowabs' server has ended");
        return SERVER_LOST;
    }
    int run = link.run;
    call.id = ++link.last_id;
    call.next = link.calls;
    link.calls = &call;
    link.heard = seconds_now();
    unlock(&link.guard);

    int sent = send_request(run, call.id, what, rest);
    lock(&link.guard);
    if (!sent && link.alive && link.run == run) child_kill(&link.child);
    while (!call.answer && link.alive && link.run == run) {
        wait_for(&link.news, &link.guard, LOOK);
        double done = call.done;
        unlock(&link.guard);
        if (!cancelled && ask && ask(asked, done)) {
            Text of = {0};
            cancelled = 1;
            text_add(&of, ", \"of\": %d", call.id);
            send_request(run, 0, "cancel", &of);
            text_free(&of);
        }
        lock(&link.guard);
        if (!call.answer && link.alive && link.run == run) see_that_it_lives();
    }
    Call **place = &link.calls;
    while (*place != &call) place = &(*place)->next;
    *place = call.next;
    unlock(&link.guard);

    ServerResult result = SERVER_LOST;
    if (call.answer) {
        result = json_true(call.answer, "ok") ? SERVER_DONE : SERVER_REFUSED;
        if (result == SERVER_REFUSED) describe_error(call.answer, why);
    } else {
        snprintf(why, WHY_ROOM, "Flowabs' server ended while it was at work");
    }
    json_free(call.answer);
    return cancelled ? SERVER_STOPPED : result;
}

/* Return the number of the server's start, 0 where none is at work. */
int server_run(void) {
    lock(&link.guard);
    int run = link.alive && link.greeted && link.owner == process_id() ? link.run : 0;
    unlock(&link.guard);
    return run;
}

/* Have the server let go of what it holds for a session, if it runs. */
void server_forget(const char *session) {
    char why[WHY_ROOM];
    Text rest = {0};
    if (!server_run()) return;
    text_add(&rest, ", \"session\": ");
    text_add_string(&rest, session);
    server_call("forget", &rest, NULL, NULL, why);
    text_free(&rest);
}

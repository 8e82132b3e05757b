/* platform.h on Linux and macOS. */

#if !defined(_WIN32)

#define _GNU_SOURCE /* dladdr, closing of files in posix_spawn */
#define _DARWIN_C_SOURCE

#include "platform.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#if defined(__APPLE__)
#include <crt_externs.h>
#define environ (*_NSGetEnviron())
#if !defined(MSG_NOSIGNAL)
#define MSG_NOSIGNAL 0 /* the socket has SO_NOSIGPIPE instead */
#endif
#else
extern char **environ;
#endif

/* ---------------------------------------------------------------------- locks, threads, the clock */

/* Wait until the lock is free, and take it. */
void lock(Lock *lock) { pthread_mutex_lock(lock); }

/* Free the lock. */
void unlock(Lock *lock) { pthread_mutex_unlock(lock); }

/* Free the lock until the signal is given or some time has passed, and take it again. */
void wait_for(Signal *signal, Lock *lock, int milliseconds) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += (long)milliseconds * 1000000;
    until.tv_sec += until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    pthread_cond_timedwait(signal, lock, &until);
}

/* Give the signal to all that wait for it. */
void wake_all(Signal *signal) { pthread_cond_broadcast(signal); }

/* Call the function that a new thread was made for. */
static void *run_thread(void *work) {
    (*(void (**)(void))work)();
    return NULL;
}

/* Start a thread, which hears no signals: they are the host's. Return whether it runs. */
int thread_start(Thread *thread, void (*work)(void)) {
    static void (*only)(void); /* there is one thread at a time */
    sigset_t all, before;
    only = work;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int failed = pthread_create(thread, NULL, run_thread, &only);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return !failed;
}

/* Wait until a thread has ended. */
void thread_join(Thread thread) { pthread_join(thread, NULL); }

/* Return the seconds of a clock that nobody sets. */
double seconds_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Return the number of this process. */
long process_id(void) { return (long)getpid(); }

/* Write the path of this very library; return whether it is known. */
int library_path(char *path, size_t room) {
    Dl_info info;
    char whole[PATH_MAX];
    if (!dladdr((void *)(size_t)&library_path, &info) || !info.dli_fname) return 0;
    const char *found = realpath(info.dli_fname, whole) ? whole : info.dli_fname;
    return snprintf(path, room, "%s", found) < (int)room;
}

/* ---------------------------------------------------------------------- the child process */

/* Return whether a variable of the environment is the host's own business: where its Python and its libraries are. */
static int is_of_host(const char *variable) {
    static const char *const names[] = {"PYTHONHOME=", "PYTHONPATH=", "LD_LIBRARY_PATH=", "LD_PRELOAD=", "DYLD_"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strncmp(variable, names[i], strlen(names[i])) == 0) return 1;
    return 0;
}

/* Return the environment for a child: a list to be freed. `python_path` is one more variable, or NULL. */
static char **clean_environment(char *python_path) {
    size_t count = 0, kept = 0;
    while (environ[count]) count++;
    char **clean = malloc((count + 2) * sizeof *clean);
    if (!clean) return NULL;
    for (size_t i = 0; i < count; i++)
        if (!is_of_host(environ[i])) clean[kept++] = environ[i];
    if (python_path) clean[kept++] = python_path;
    clean[kept] = NULL;
    return clean;
}

/* Make two ends of a socket, both above the files 0, 1 and 2, closed in other children. Return whether there are any.
 */
static int make_sockets(int ends[2]) {
    int pair[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, pair) != 0) return 0;
    for (int i = 0; i < 2; i++) {
        ends[i] = fcntl(pair[i], F_DUPFD_CLOEXEC, 3);
        close(pair[i]);
    }
#if defined(__APPLE__)
    int on = 1;
    setsockopt(ends[0], SOL_SOCKET, SO_NOSIGPIPE, &on, sizeof on);
#endif
    if (ends[0] >= 0 && ends[1] >= 0) return 1;
    if (ends[0] >= 0) close(ends[0]);
    if (ends[1] >= 0) close(ends[1]);
    return 0;
}

/* Start a program with `socket` as its stdin and stdout, without the host's other files, in a process group of its own
   (Ctrl-C is for the host), with signals as usual. Return 0, or the number of the error. */
static int spawn(pid_t *process, const char *const *words, char **environment, int socket) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t how;
    sigset_t none, all;
    short flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&how);
    posix_spawn_file_actions_adddup2(&files, socket, 0);
    posix_spawn_file_actions_adddup2(&files, socket, 1);
#if defined(__APPLE__)
    flags |= POSIX_SPAWN_CLOEXEC_DEFAULT;
    posix_spawn_file_actions_addinherit_np(&files, 2);
#elif defined(__GLIBC__) && (__GLIBC__ > 2 || (__GLIBC__ == 2 && __GLIBC_MINOR__ >= 34))
    posix_spawn_file_actions_addclosefrom_np(&files, 3);
#endif
    posix_spawnattr_setsigmask(&how, &none);
    posix_spawnattr_setsigdefault(&how, &all);
    posix_spawnattr_setpgroup(&how, 0);
    posix_spawnattr_setflags(&how, flags);
    int failed = posix_spawnp(process, words[0], &files, &how, (char *const *)words, environment);
    posix_spawnattr_destroy(&how);
    posix_spawn_file_actions_destroy(&files);
    return failed;
}

/* Start a program, `words`, whose last is NULL. `python_path` is where it finds modules beside its own, or "".
   Return whether it runs; `why` says why not. */
int child_start(Child *child, const char *const *words, const char *python_path, char *why) {
    char variable[PATH_ROOM + 16];
    int ends[2];
    snprintf(variable, sizeof variable, "PYTHONPATH=%s", python_path);
    char **environment = clean_environment(*python_path ? variable : NULL);
    if (!environment || !make_sockets(ends)) {
        snprintf(why, WHY_ROOM, "%s", strerror(environment ? errno : ENOMEM));
        free(environment);
        return 0;
    }
    int failed = spawn(&child->process, words, environment, ends[1]);
    free(environment);
    close(ends[1]);
    child->socket = ends[0];
    if (failed) {
        snprintf(why, WHY_ROOM, "%s", strerror(failed));
        close(ends[0]);
    }
    return !failed;
}

/* Send bytes; return whether all are on their way. `patience` is in seconds. */
int child_send(Child *child, const void *bytes, size_t count, double patience) {
    const char *at = bytes;
    double until = seconds_now() + patience;
    while (count > 0) {
        ssize_t sent = send(child->socket, at, count, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent > 0) {
            at += sent;
            count -= (size_t)sent;
        } else if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS) {
            struct pollfd wanted = {child->socket, POLLOUT, 0};
            if (seconds_now() > until) return 0;
            poll(&wanted, 1, 20);
        } else if (errno != EINTR) {
            return 0;
        }
    }
    return 1;
}

/* Wait for just so many bytes; return 0 where the child has ended, or hung up. */
int child_receive(Child *child, void *bytes, size_t count) {
    char *at = bytes;
    while (count > 0) {
        ssize_t received = recv(child->socket, at, count, 0);
        if (received > 0) {
            at += received;
            count -= (size_t)received;
        } else if (received == 0 || errno != EINTR) {
            return 0;
        }
    }
    return 1;
}

/* Have child_receive, in another thread, return. The child's stdin ends. */
void child_hang_up(Child *child) { shutdown(child->socket, SHUT_RDWR); }

/* End the child and all that it has started at once. */
void child_kill(Child *child) { kill(-child->process, SIGKILL); }

/* Wait for the child to end, kill it when the patience is over (in seconds), and clear away what is left of it. */
void child_end(Child *child, double patience) {
    double until = seconds_now() + patience;
    int status;
    close(child->socket);
    for (;;) {
        pid_t ended = waitpid(child->process, &status, WNOHANG);
        if (ended == child->process || (ended < 0 && errno != EINTR)) return; /* a host may have waited for it itself */
        if (seconds_now() > until) break;
        struct timespec pause = {0, 2000000};
        nanosleep(&pause, NULL);
    }
    child_kill(child);
    while (waitpid(child->process, &status, 0) < 0 && errno == EINTR) continue;
}

/* ---------------------------------------------------------------------- shared memory */

/* Make a file of this size in a folder, for this user alone, and map it; return whether there is one.
   All of it is reserved: writing to memory whose file has no room on its disk would end the host. */
static int shared_make_in(Shared *shared, const char *folder, size_t size) {
    int file = -1;
    for (int tries = 0; tries < 100 && file < 0; tries++) {
        unsigned long mixed = (unsigned long)(seconds_now() * 1e9) ^ (unsigned long)(size_t)shared;
        snprintf(shared->name, sizeof shared->name, "%s/flowabs-%ld-%016lx", folder, (long)getpid(), mixed);
        file = open(shared->name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (file < 0 && errno != EEXIST) return 0;
    }
    if (file < 0) return 0;
#if defined(__APPLE__)
    int failed = ftruncate(file, (off_t)size);
#else
    int failed = posix_fallocate(file, 0, (off_t)size);
#endif
    void *bytes = failed ? MAP_FAILED : mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (bytes == MAP_FAILED) {
        unlink(shared->name);
        return 0;
    }
    shared->bytes = bytes;
    shared->size = size;
    return 1;
}

/* Make memory that a child can map; return whether there is any. */
int shared_make(Shared *shared, size_t size) {
    const char *own = getenv("TMPDIR");
    memset(shared, 0, sizeof *shared);
    return shared_make_in(shared, "/dev/shm", size) || (own && *own && shared_make_in(shared, own, size)) ||
           shared_make_in(shared, "/tmp", size);
}

/* Take the name away: nobody else can map the memory, and nothing is left when both processes have ended. */
void shared_forget_name(Shared *shared) {
    if (*shared->name) unlink(shared->name);
    *shared->name = 0;
}

/* Let go of the memory. */
void shared_free(Shared *shared) {
    shared_forget_name(shared);
    if (shared->bytes) munmap(shared->bytes, shared->size);
    shared->bytes = NULL;
}

#endif

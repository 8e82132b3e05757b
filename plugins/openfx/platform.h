/* What differs between POSIX and Windows: locks, threads, the clock, the child process, memory that is shared with it.

   platform_posix.c and platform_windows.c are the two answers. */

#ifndef FLOWABS_PLATFORM_H
#define FLOWABS_PLATFORM_H

#include <stddef.h>

#if defined(_WIN32)
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
typedef SRWLOCK Lock;
typedef CONDITION_VARIABLE Signal;
typedef HANDLE Thread;
#define LOCK_START SRWLOCK_INIT
#define SIGNAL_START CONDITION_VARIABLE_INIT
#else
#include <pthread.h>
#include <sys/types.h>
typedef pthread_mutex_t Lock;
typedef pthread_cond_t Signal;
typedef pthread_t Thread;
#define LOCK_START PTHREAD_MUTEX_INITIALIZER
#define SIGNAL_START PTHREAD_COND_INITIALIZER
#endif

enum { PATH_ROOM = 4096, WHY_ROOM = 1024 };

/* A process that reads what is sent to it from its stdin; what it prints to its stdout is received. */
typedef struct Child {
#if defined(_WIN32)
    HANDLE process, to, from;
#else
    pid_t process;
    int socket;
#endif
} Child;

/* Memory that a child may map too, by the name of a file (POSIX) or a tag (Windows). */
typedef struct Shared {
    unsigned char *bytes;
    size_t size;
    char name[PATH_ROOM];
#if defined(_WIN32)
    HANDLE mapping;
#endif
} Shared;

/* How shared memory is named in the message "map". */
#if defined(_WIN32)
#define SHARED_NAME_KEY "name"
#else
#define SHARED_NAME_KEY "path"
#endif

void lock(Lock *lock);
void unlock(Lock *lock);
void wait_for(Signal *signal, Lock *lock, int milliseconds);
void wake_all(Signal *signal);
int thread_start(Thread *thread, void (*work)(void));
void thread_join(Thread thread);
double seconds_now(void);
long process_id(void);

int library_path(char *path, size_t room);

int child_start(Child *child, const char *const *words, const char *python_path, char *why);
int child_send(Child *child, const void *bytes, size_t count, double patience);
int child_receive(Child *child, void *bytes, size_t count);
void child_hang_up(Child *child);
void child_kill(Child *child);
void child_end(Child *child, double patience);

int shared_make(Shared *shared, size_t size);
void shared_forget_name(Shared *shared);
void shared_free(Shared *shared);

#endif

/* platform.h on Windows. It compiles; nobody has run it yet. */

#if defined(_WIN32)

#include "platform.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---------------------------------------------------------------------- locks, threads, the clock */

/* Wait until the lock is free, and take it. */
void lock(Lock *lock) { AcquireSRWLockExclusive(lock); }

/* Free the lock. */
void unlock(Lock *lock) { ReleaseSRWLockExclusive(lock); }

/* Free the lock until the signal is given or some time has passed, and take it again. */
void wait_for(Signal *signal, Lock *lock, int milliseconds) {
    SleepConditionVariableSRW(signal, lock, (DWORD)milliseconds, 0);
}

/* Give the signal to all that wait for it. */
void wake_all(Signal *signal) { WakeAllConditionVariable(signal); }

/* Call the function that a new thread was made for. */
static DWORD WINAPI run_thread(LPVOID work) {
    (*(void (**)(void))work)();
    return 0;
}

/* Start a thread; return whether it runs. */
int thread_start(Thread *thread, void (*work)(void)) {
    static void (*only)(void); /* there is one thread at a time */
    only = work;
    *thread = CreateThread(NULL, 0, run_thread, &only, 0, NULL);
    return *thread != NULL;
}

/* Wait until a thread has ended. */
void thread_join(Thread thread) {
    WaitForSingleObject(thread, INFINITE);
    CloseHandle(thread);
}

/* Return the seconds of a clock that nobody sets. */
double seconds_now(void) { return (double)GetTickCount64() / 1000; }

/* Return the number of this process. */
long process_id(void) { return (long)GetCurrentProcessId(); }

/* Convert UTF-8 to Windows' own characters; return new memory, or NULL. */
static wchar_t *wide(const char *text) {
    int count = MultiByteToWideChar(CP_UTF8, 0, text, -1, NULL, 0);
    wchar_t *out = malloc((size_t)count * sizeof *out);
    if (out) MultiByteToWideChar(CP_UTF8, 0, text, -1, out, count);
    return out;
}

/* Write the path of this very library, in UTF-8; return whether it is known. */
int library_path(char *path, size_t room) {
    HMODULE module;
    wchar_t found[PATH_ROOM];
    DWORD how = GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT;
    if (!GetModuleHandleExW(how, (LPCWSTR)(void *)(size_t)&library_path, &module)) return 0;
    DWORD length = GetModuleFileNameW(module, found, PATH_ROOM);
    if (length == 0 || length == PATH_ROOM) return 0;
    if (!WideCharToMultiByte(CP_UTF8, 0, found, -1, path, (int)room, NULL, NULL)) return 0;
    for (char *c = path; *c; c++)
        if (*c == '\\') *c = '/';
    return 1;
}

/* ---------------------------------------------------------------------- the child process */

/* Add a word to a command line as programs on Windows take it apart: in quotes, with \" for a quote in it. */
static void add_word(char *line, size_t room, const char *word) {
    size_t at = strlen(line), slashes = 0;
    if (at && at + 1 < room) line[at++] = ' ';
    if (at + 1 < room) line[at++] = '"';
    for (; *word; word++) {
        slashes = *word == '\\' ? slashes + 1 : slashes;
        if (*word == '"')
            for (size_t i = 0; i <= slashes && at + 1 < room; i++) line[at++] = '\\';
        if (*word != '\\') slashes = 0;
        if (at + 1 < room) line[at++] = *word;
    }
    for (size_t i = 0; i < slashes && at + 1 < room; i++) line[at++] = '\\';
    if (at + 1 < room) line[at++] = '"';
    line[at] = 0;
}

/* Return the environment for a child, without where the host's Python is; a list to be freed. */
static wchar_t *clean_environment(const wchar_t *python_path) {
    wchar_t *all = GetEnvironmentStringsW();
    size_t length = 0;
    if (!all) return NULL;
    while (all[length]) length += wcslen(all + length) + 1;
    wchar_t *clean = malloc((length + wcslen(python_path) + 16) * sizeof *clean), *out = clean;
    for (wchar_t *one = all; clean && *one; one += wcslen(one) + 1) {
        if (_wcsnicmp(one, L"PYTHONHOME=", 11) == 0 || _wcsnicmp(one, L"PYTHONPATH=", 11) == 0) continue;
        wcscpy(out, one);
        out += wcslen(out) + 1;
    }
    if (clean && *python_path) {
        wcscpy(out, L"PYTHONPATH=");
        wcscat(out, python_path);
        out += wcslen(out) + 1;
    }
    if (clean) *out = 0;
    FreeEnvironmentStringsW(all);
    return clean;
}

/* Start a process on three handles, of which it gets no others; return whether it runs. */
static int spawn(HANDLE *process, wchar_t *line, wchar_t *environment, HANDLE in, HANDLE out) {
    PROCESS_INFORMATION made;
    STARTUPINFOEXW how;
    HANDLE inherited[3] = {in, out, GetStdHandle(STD_ERROR_HANDLE)};
    DWORD count = inherited[2] && inherited[2] != INVALID_HANDLE_VALUE ? 3 : 2, flags = 0;
    if (count == 3 && !(GetHandleInformation(inherited[2], &flags) && (flags & HANDLE_FLAG_INHERIT))) count = 2;
    SIZE_T room = 0;
    memset(&how, 0, sizeof how);
    InitializeProcThreadAttributeList(NULL, 1, 0, &room);
    how.lpAttributeList = malloc(room);
    if (!how.lpAttributeList) return 0;
    InitializeProcThreadAttributeList(how.lpAttributeList, 1, 0, &room);
    UpdateProcThreadAttribute(
        how.lpAttributeList, 0, PROC_THREAD_ATTRIBUTE_HANDLE_LIST, inherited, count * sizeof *inherited, NULL, NULL
    );
    how.StartupInfo.cb = sizeof how;
    how.StartupInfo.dwFlags = STARTF_USESTDHANDLES;
    how.StartupInfo.hStdInput = in;
    how.StartupInfo.hStdOutput = out;
    how.StartupInfo.hStdError = count == 3 ? inherited[2] : NULL;
    DWORD as = CREATE_NO_WINDOW | CREATE_UNICODE_ENVIRONMENT | EXTENDED_STARTUPINFO_PRESENT;
    int runs = CreateProcessW(NULL, line, NULL, NULL, TRUE, as, environment, NULL, &how.StartupInfo, &made);
    DeleteProcThreadAttributeList(how.lpAttributeList);
    free(how.lpAttributeList);
    if (!runs) return 0;
    CloseHandle(made.hThread);
    *process = made.hProcess;
    return 1;
}

/* Start a program, `words`, whose last is NULL. `python_path` is where it finds modules beside its own, or "".
   Return whether it runs; `why` says why not. */
int child_start(Child *child, const char *const *words, const char *python_path, char *why) {
    char line[PATH_ROOM * 2] = "";
    SECURITY_ATTRIBUTES inherit = {sizeof inherit, NULL, TRUE};
    HANDLE in = NULL, out = NULL;
    for (; *words; words++) add_word(line, sizeof line, *words);
    wchar_t *command = wide(line), *path = wide(python_path), *environment = path ? clean_environment(path) : NULL;
    int runs = command && environment && CreatePipe(&in, &child->to, &inherit, 1 << 16);
    if (runs && !CreatePipe(&child->from, &out, &inherit, 1 << 16)) {
        CloseHandle(child->to);
        runs = 0;
    } else if (runs) {
        SetHandleInformation(child->to, HANDLE_FLAG_INHERIT, 0);
        SetHandleInformation(child->from, HANDLE_FLAG_INHERIT, 0);
        runs = spawn(&child->process, command, environment, in, out);
        if (!runs) snprintf(why, WHY_ROOM, "error %lu", (unsigned long)GetLastError());
        if (!runs) CloseHandle(child->to);
        if (!runs) CloseHandle(child->from);
    }
    if (in) CloseHandle(in);
    if (out) CloseHandle(out);
    free(command);
    free(path);
    free(environment);
    return runs;
}

/* Send bytes; return whether all are on their way. A pipe of Windows has no time limit: `patience` says nothing. */
int child_send(Child *child, const void *bytes, size_t count, double patience) {
    const char *at = bytes;
    (void)patience;
    while (count > 0) {
        DWORD sent = 0;
        if (!WriteFile(child->to, at, (DWORD)(count < 1 << 20 ? count : 1 << 20), &sent, NULL) || !sent) return 0;
        at += sent;
        count -= sent;
    }
    return 1;
}

/* Wait for just so many bytes; return 0 where the child has ended, or was hung up. */
int child_receive(Child *child, void *bytes, size_t count) {
    char *at = bytes;
    while (count > 0) {
        DWORD received = 0;
        if (!ReadFile(child->from, at, (DWORD)(count < 1 << 20 ? count : 1 << 20), &received, NULL) || !received)
            return 0;
        at += received;
        count -= received;
    }
    return 1;
}

/* End the child's stdin: it ends, and child_receive, in another thread, returns. */
void child_hang_up(Child *child) {
    CloseHandle(child->to);
    child->to = NULL;
    if (WaitForSingleObject(child->process, 2000) != WAIT_OBJECT_0) child_kill(child);
}

/* End the child at once. */
void child_kill(Child *child) { TerminateProcess(child->process, 1); }

/* Wait for the child to end, kill it when the patience is over (in seconds), and clear away what is left of it. */
void child_end(Child *child, double patience) {
    if (WaitForSingleObject(child->process, (DWORD)(patience * 1000)) != WAIT_OBJECT_0) child_kill(child);
    if (child->to) CloseHandle(child->to);
    CloseHandle(child->from);
    CloseHandle(child->process);
}

/* ---------------------------------------------------------------------- shared memory */

/* Make memory that a child can map by its tag; return whether there is any. */
int shared_make(Shared *shared, size_t size) {
    static LONG count;
    memset(shared, 0, sizeof *shared);
    snprintf(
        shared->name, sizeof shared->name, "flowabs-%lu-%lu-%lu", (unsigned long)GetCurrentProcessId(),
        (unsigned long)GetTickCount64(), (unsigned long)InterlockedIncrement(&count)
    );
    DWORD high = (DWORD)((unsigned long long)size >> 32), low = (DWORD)(size & 0xFFFFFFFFu);
    shared->mapping = CreateFileMappingA(INVALID_HANDLE_VALUE, NULL, PAGE_READWRITE, high, low, shared->name);
    if (!shared->mapping) return 0;
    int fresh = GetLastError() != ERROR_ALREADY_EXISTS;
    shared->bytes = fresh ? MapViewOfFile(shared->mapping, FILE_MAP_ALL_ACCESS, 0, 0, size) : NULL;
    shared->size = size;
    if (!shared->bytes) CloseHandle(shared->mapping);
    return shared->bytes != NULL;
}

/* Do nothing: a tag goes with the last process that has the memory mapped. */
void shared_forget_name(Shared *shared) { (void)shared; }

/* Let go of the memory. */
void shared_free(Shared *shared) {
    if (!shared->bytes) return;
    UnmapViewOfFile(shared->bytes);
    CloseHandle(shared->mapping);
    shared->bytes = NULL;
}

#endif

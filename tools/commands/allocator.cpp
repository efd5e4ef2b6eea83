// How jemalloc treats memory, read by it before main begins (see "malloc_conf" in its manual).
//
// A plan and its frames take and give back the same few hundred megabytes again and again. By default the C library
// returns such memory to the system and has it mapped anew, 4 KB at a time: a fifth of a morph's time. Here it is mapped
// in pages of 2 MB where the system has them, and kept to the end: what was returned in between had to be cleared by the
// system when it was taken again, a twentieth of a frame's time. What is larger than 1 MB comes from one arena for all
// threads, where another thread takes it again, not from one of each thread's own.

extern "C" {

// Declared here, for jemalloc's header has it under other names on other systems.
extern const char* malloc_conf;

const char* malloc_conf =
    "thp:always,metadata_thp:always,dirty_decay_ms:-1,muzzy_decay_ms:-1,oversize_threshold:1048576";
}

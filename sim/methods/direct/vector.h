// Vector code for more than one kind of processor.
#pragma once

// Compiles a function twice, for any x86-64 and for those with AVX2 and FMA, and chooses when the
// program starts. Only plain loops profit: what they call must be inlined.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define TAUT_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define TAUT_VECTOR_CLONES
#endif

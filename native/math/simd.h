// SPDX-License-Identifier: GPL-3.0-or-later
// Loops that the compiler vectorises for several instruction sets; the best one is chosen when the module is
// loaded. Without contraction (-ffp-contract=off) and with elementwise arithmetic the results are the same
// bit for bit in each.
#pragma once

// Clang has no clones of function templates, and other compilers none at all: there it is the baseline alone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(PENUMBRA_NO_CLONES)
#define PENUMBRA_CLONES
#define PENUMBRA_VECTORIZED __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define PENUMBRA_VECTORIZED
#endif

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace penumbra {

/// Denormals count as zero in this thread: scenes of extreme radiance do not stall, and Embree asks for it.
inline void flush_denormals() {
#if defined(__SSE2__)
  _mm_setcsr(_mm_getcsr() | 0x8040u);  // flush to zero, denormals are zero
#endif
}

/// The instruction set that vectorised loops use on this CPU.
inline const char* vector_isa() {
#if defined(PENUMBRA_CLONES)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) return "avx512";
  if (__builtin_cpu_supports("avx2")) return "avx2";
#endif
#if defined(__x86_64__)
  return "sse4.2";
#else
  return "generic";
#endif
}

}  // namespace penumbra

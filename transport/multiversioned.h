// Kernels that are compiled for several instruction sets, of which the loader takes the widest that there is.
#pragma once

// Sanitizers are not ready yet when the loader chooses among the clones.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BAKELIGHT_MULTIVERSIONED __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BAKELIGHT_MULTIVERSIONED
#endif

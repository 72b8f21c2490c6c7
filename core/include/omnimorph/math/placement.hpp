// Where a function may run: everywhere. A compiler for a device reads OMNIMORPH_FN as "on the host and on the device".
#pragma once

#if defined(__CUDACC__) || defined(__HIPCC__)
#define OMNIMORPH_FN __host__ __device__ inline
#else
#define OMNIMORPH_FN inline
#endif

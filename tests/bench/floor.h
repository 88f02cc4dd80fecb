// The best that this machine can do, for other benchmarks to be compared with.
#pragma once

namespace taut::bench {

/// s, of a multiply-add whose operand is the result of the one before: what a sweep along a chain
/// waits for at each link, however wide the machine is.
double multiply_add_latency();

/// s per byte read and written again, of as much as the innermost cache holds.
double byte_time();

}  // namespace taut::bench

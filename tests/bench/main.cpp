// The benchmarks. Those of every method are registered once all methods have joined the list.
#include <benchmark/benchmark.h>

namespace taut {
void register_interventions();  // interventions.cpp
}

int main(int argc, char** argv) {
  taut::register_interventions();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}

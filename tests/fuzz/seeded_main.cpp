// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a fuzz target without libFuzzer: on files, or on random inputs by number.
//   fuzz_scene FILE ...          fuzz_scene --runs N [--seed S]
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int main(int count, char** arguments) {
  unsigned long runs = 0, seed = 0;
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (i + 1 < count && argument == "--runs") {
      runs = std::strtoul(arguments[++i], nullptr, 10);
    } else if (i + 1 < count && argument == "--seed") {
      seed = std::strtoul(arguments[++i], nullptr, 10);
    } else {
      std::ifstream file(argument, std::ios::binary);
      const std::vector<char> bytes(std::istreambuf_iterator<char>(file), {});
      if (!file) {
        std::fprintf(stderr, "cannot read %s\n", argument.c_str());
        return 1;
      }
      LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
    }
  }
  for (unsigned long run = 0; run < runs; ++run) {
    std::mt19937_64 random(seed + run);
    std::vector<uint8_t> bytes(256 + random() % 1024);
    const uint64_t most =
        100 + random() % 157;  // without high bytes numbers are plain, and more gets rendered
    for (uint8_t& byte : bytes) byte = uint8_t(random() % most);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  std::printf("%lu random inputs\n", runs);
  return 0;
}

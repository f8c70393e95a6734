// Runs the corpus, and seeded mutations of it, through every reader: this needs no libFuzzer and is
// part of every test run. `./dev fuzz` continues from the same corpus, guided by coverage.
//
// OCCLUDE_FUZZ_RUNS in the environment: mutations per target (default 300).
#include "fuzz/targets.h"

#include "support/source_dir.h"

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace occlude::fuzz {
namespace {

namespace fs = std::filesystem;
using Input = std::vector<uint8_t>;

std::vector<Input> corpus_of(std::string_view target)
{
    std::vector<fs::path> files;
    const fs::path folder = fs::path{source_dir()} / "tests/fuzz/corpus" / target;
    for (const auto& entry : fs::directory_iterator{folder}) {
        files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    std::vector<Input> inputs;
    for (const fs::path& file : files) {
        std::ifstream stream{file, std::ios::binary};
        inputs.emplace_back(std::istreambuf_iterator<char>{stream},
                            std::istreambuf_iterator<char>{});
    }
    return inputs;
}

/// Some bytes are changed, cut out, doubled, or taken from another input.
Input mutated(const std::vector<Input>& corpus, Rng& rng)
{
    const auto below = [&](size_t count) {
        return static_cast<std::ptrdiff_t>(rng.below(static_cast<uint32_t>(count)));
    };
    Input input = corpus[static_cast<size_t>(below(corpus.size()))];
    for (uint32_t change = 1 + rng.below(6); change > 0 && !input.empty(); --change) {
        const std::ptrdiff_t at = below(input.size());
        const std::ptrdiff_t end =
            std::min<std::ptrdiff_t>(at + 1 + below(24), static_cast<std::ptrdiff_t>(input.size()));
        switch (rng.below(6)) {
        case 0:
            input[static_cast<size_t>(at)] = static_cast<uint8_t>(rng.below(256));
            break;
        case 1:
            input[static_cast<size_t>(at)] ^= static_cast<uint8_t>(1u << rng.below(8));
            break;
        case 2:
            input.erase(input.begin() + at, input.begin() + end);
            break;
        case 3: {
            const Input part(input.begin() + at, input.begin() + end);
            input.insert(input.begin() + at, part.begin(), part.end());
            break;
        }
        case 4: {
            constexpr std::string_view kHard[] = {"-1",  "1e999", "nan",     "99999999999999999999",
                                                  "[[[", "\"",    "{\"a\":", "\xff\xfe",
                                                  "0x",  ""};
            const std::string_view word = kHard[rng.below(std::size(kHard))];
            input.insert(input.begin() + at, word.begin(), word.end());
            break;
        }
        default: {
            const Input& other = corpus[static_cast<size_t>(below(corpus.size()))];
            if (!other.empty()) {
                const std::ptrdiff_t from = below(other.size());
                input.insert(input.begin() + at, other.begin() + from, other.end());
            }
        }
        }
    }
    return input;
}

size_t runs()
{
    const char* wanted = std::getenv("OCCLUDE_FUZZ_RUNS");
    return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 300;
}

class Fuzz : public testing::TestWithParam<size_t> {};

TEST_P(Fuzz, NeitherTheCorpusNorMutationsOfItCrashAReader)
{
    const Target& target = kTargets[GetParam()];
    const std::vector<Input> corpus = corpus_of(target.name);
    ASSERT_GE(corpus.size(), 2u) << target.name;
    for (const Input& input : corpus) {
        target.run(input);
    }
    // Scenes are read in a process of their own, which takes longer.
    const size_t count = target.name == "scene" ? runs() / 4 : runs();
    for (size_t i = 0; i < count; ++i) {
        SCOPED_TRACE("mutation " + std::to_string(i) + " of " + std::string{target.name});
        Rng rng{hash64(GetParam(), i)};
        target.run(mutated(corpus, rng));
    }
}

INSTANTIATE_TEST_SUITE_P(Every, Fuzz, testing::Range(size_t{0}, kTargets.size()),
                         [](const auto& info) { return std::string{kTargets[info.param].name}; });

} // namespace
} // namespace occlude::fuzz

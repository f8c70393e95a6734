// What an algorithm says about itself: the constant `kTraits` of its class, which the registry
// collects.
#pragma once

#include <cstdint>
#include <string_view>

namespace occlude {

/// What an algorithm needs beyond drawing.
struct Needs {
    bool queries = false;     ///< asks the device tests
    bool depth_read = false;  ///< reads the depth buffer
    bool visible_set = false; ///< must be told beforehand what is visible: an OracleCuller
};

/// How an algorithm uses the nodes of the hierarchy, which decides which kinds of trees suit it.
enum class NodeUse : uint8_t {
    walks,  ///< it descends from node to node: every kind of tree suits it
    leaves, ///< it tests leaves only and draws the items of inner nodes: trees that keep items in
            ///< inner nodes do not suit it
    none,   ///< it reads the items alone: the kind of tree makes no difference
};

struct AlgorithmTraits {
    std::string_view name;    ///< the name of its files, of its options and in `--algorithms`
    std::string_view paper;   ///< who published it, or "baseline"
    std::string_view summary; ///< half a sentence
    Needs needs = {};
    NodeUse node_use = NodeUse::walks;
    bool exact = true;     ///< with its default options, every frame is Guarantee::exact()
    bool remembers = true; ///< state that one frame leaves changes what later frames do or cost
};

/// The options of an algorithm that has none.
struct NoOptions {};
template <class Visit>
void visit_options(NoOptions&, Visit&&)
{
}

} // namespace occlude

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
    bool visible_set = false; ///< must be told the answer beforehand: an OracleCuller
};

/// What an algorithm does with the nodes of the hierarchy; decides which kinds of trees suit it.
enum class NodeUse : uint8_t {
    walks,  ///< it descends from node to node: every kind suits it
    leaves, ///< it tests leaves only and draws what lies in inner nodes: kinds that keep items in
            ///< inner nodes do not suit it
    none,   ///< it takes the items alone: all kinds are alike to it
};

struct AlgorithmTraits {
    std::string_view name;    ///< as its files, its options and `--algorithms` name it
    std::string_view paper;   ///< who published it, or "baseline"
    std::string_view summary; ///< half a sentence
    Needs needs = {};
    NodeUse node_use = NodeUse::walks;
    bool exact = true;     ///< with its default options, every frame is Guarantee::exact()
    bool remembers = true; ///< what it saw or built in a frame changes what later frames do or cost
};

/// The options of an algorithm that has none.
struct NoOptions {};
template <class Visit>
void visit_options(NoOptions&, Visit&&)
{
}

} // namespace occlude

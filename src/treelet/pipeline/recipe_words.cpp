#include <treelet/pipeline/recipe_words.h>

#include <array>

#include <treelet/build/binned.h>
#include <treelet/build/grid_sah.h>
#include <treelet/build/hlbvh.h>
#include <treelet/build/hploc.h>
#include <treelet/build/node_bins.h>
#include <treelet/build/ploc.h>
#include <treelet/build/sbvh.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/optimize/agglomeration.h>
#include <treelet/optimize/insertion.h>
#include <treelet/optimize/reinsertion.h>
#include <treelet/optimize/rotation.h>
#include <treelet/optimize/subset_tables.h>

namespace treelet {
namespace {

constexpr WordParameter kSplitBudget{"budget", 30, 0, 300,
                                     "references added at most, in percent of the triangles"};

constexpr std::array<WordParameter, 1> kPresplitParameters{{kSplitBudget}};

constexpr WordParameter kMargin{"margin", 2, 0, 100,
                                "percent of rays' work that splits must save, or they are refused"};

constexpr std::array<WordParameter, 2> kTrysplitParameters{{kSplitBudget, kMargin}};

constexpr std::array<WordParameter, 1> kHplocParameters{{
    {"radius", HplocConfig{}.radius, kMinHplocRadius, kMaxHplocRadius,
     "clusters on either side among which the nearest is looked for"},
}};

constexpr std::array<WordParameter, 1> kPlocParameters{{
    {"radius", PlocConfig{}.radius, kMinPlocRadius, kMaxPlocRadius,
     "clusters on either side among which the nearest is looked for"},
}};

constexpr WordParameter kBinsParameter{"bins", BinnedConfig{}.bins, kMinNodeBins, kMaxNodeBins,
                                       "of an axis, between which nodes are parted"};

constexpr std::array<WordParameter, 1> kBinnedParameters{{kBinsParameter}};

constexpr std::array<WordParameter, 2> kHlbvhParameters{{
    {"bits", HlbvhConfig{}.bits, 0, kMaxHlbvhBits, "of the Morton codes that make the clusters"},
    kBinsParameter,
}};

constexpr std::array<WordParameter, 2> kGridSahParameters{{
    {"bits", GridSahConfig{}.bits, kMinGridBits, kMaxGridBits,
     "of the Morton codes that a grid takes"},
    kBinsParameter,
}};

constexpr WordParameter kSbvhBudget{"budget", SbvhConfig{}.budget, 0, kMaxSbvhBudget,
                                    "references added at most, in percent of those before"};

constexpr std::array<WordParameter, 1> kSbvhParameters{{kSbvhBudget}};

constexpr std::array<WordParameter, 2> kTrysbvhParameters{{kSbvhBudget, kMargin}};

constexpr std::array<WordParameter, 2> kReinsertParameters{{
    {"percent", ReinsertionConfig{}.percent, 0, 10, "of all nodes, the largest, are looked at"},
    {"rounds", ReinsertionConfig{}.rounds, 0, 16, "passes over the tree"},
}};

constexpr std::array<WordParameter, 3> kInsertParameters{{
    {"percent", InsertionConfig{}.percent, 0, 10, "of the internal nodes, in a batch"},
    {"batches", InsertionConfig{}.batches, 0, 1000, "at most; ends where they stop to help"},
    {"seed", InsertionConfig{}.seed, 0, 1e9, "of batches that are picked at random"},
}};

constexpr std::array<WordParameter, 3> kRotateParameters{{
    {"rounds", RotationConfig{}.rounds, 0, 100, "passes over the tree at most"},
    {"anneal", RotationConfig{}.anneal, 0, 1000, "passes that take rotations for the worse, too"},
    {"seed", RotationConfig{}.seed, 0, 1e9, "of those passes"},
}};

constexpr std::array<WordParameter, 2> kAgglomerateParameters{{
    {"size", AgglomerationConfig{}.size, kMinAgglomeratedSize, kMaxAgglomeratedSize,
     "leaves of a treelet"},
    {"rounds", AgglomerationConfig{}.rounds, 0, 16, "passes over the tree"},
}};

constexpr std::array<WordParameter, 3> kTreeletParameters{{
    {"size", 7, kMinTreeletSize, kMaxTreeletSize, "leaves of a treelet"},
    {"rounds", 3, 0, 16, "passes over the tree"},
    {"gamma", 0, 0, 1e9,
     "references below a treelet's root at least, doubled each round; 0 stands for size"},
}};

constexpr std::array<WordParameter, 1> kBvh2Parameters{{
    {"leaf", 8, 1, 64, "triangles in a leaf at most"},
}};

constexpr std::array<WordParameter, 1> kBvh8Parameters{{
    {"leaf", 8, 1, WideChild::kMaxBlocks * TriangleBlock::kTriangles,
     "triangles in a leaf at most"},
}};

constexpr std::array<WordParameter, 1> kCwbvhParameters{{
    {"leaf", CwbvhNode::kMaxLeaf, 1, CwbvhNode::kMaxLeaf, "triangles in a leaf at most"},
}};

constexpr std::array<RecipeWord, 19> kWords{{
    {"presplit", WordKind::splitter,
     "splits triangles that fill little of their boxes (Karras and Aila 2013)",
     kPresplitParameters},
    {"trysplit", WordKind::splitter,
     "builds with presplit and without, and keeps the tree that rays cost less in",
     kTrysplitParameters},
    {"trysbvh", WordKind::splitter,
     "builds with sbvh for the builder and as told, keeps the tree that rays cost less in",
     kTrysbvhParameters},
    {"lbvh", WordKind::builder, "radix tree over 63-bit Morton codes (Karras 2012)", {}},
    {"hploc", WordKind::builder, "clustering of neighbours in Morton order (Benthin et al. 2024)",
     kHplocParameters},
    {"ploc", WordKind::builder,
     "clustering of all neighbours in Morton order (Meister and Bittner 2018)", kPlocParameters},
    {"hlbvh", WordKind::builder,
     "LBVH below cells of a grid, binned SAH above (Garanzha et al. 2011)", kHlbvhParameters},
    {"gridsah", WordKind::builder, "SAH over cells of nested grids (Garanzha et al. 2011)",
     kGridSahParameters},
    {"binned", WordKind::builder, "top-down binned SAH (Wald 2007)", kBinnedParameters},
    {"sweep", WordKind::builder, "top-down full-sweep SAH: slow, the quality reference", {}},
    {"sbvh", WordKind::builder,
     "top-down with spatial splits (Stich et al. 2009): slow, long triangles gain",
     kSbvhParameters},
    {"treelet", WordKind::optimizer, "optimal restructuring of treelets (Karras and Aila 2013)",
     kTreeletParameters},
    {"reinsert", WordKind::optimizer, "large nodes to better places (Meister and Bittner 2018)",
     kReinsertParameters},
    {"insert", WordKind::optimizer,
     "children of wasteful nodes to better places (Bittner et al. 2013): slow", kInsertParameters},
    {"rotate", WordKind::optimizer, "swaps of children and grandchildren (Kensler 2008)",
     kRotateParameters},
    {"atr", WordKind::optimizer,
     "agglomerative restructuring of treelets (Domingues and Pedrini 2015)",
     kAgglomerateParameters},
    {"bvh2", WordKind::layout, "binary nodes with both children's boxes, leaves by SAH",
     kBvh2Parameters},
    {"bvh8", WordKind::layout, "nodes of eight children for SIMD, blocks of four triangles",
     kBvh8Parameters},
    {"cwbvh", WordKind::layout,
     "eight children in 80 bytes, for CUDA (Ylitie, Karras and Laine 2017)", kCwbvhParameters},
}};

constexpr std::array<Preset, 4> kPresets{{
    {"fast", "lbvh > bvh8", "quickest build: for a few million rays a frame"},
    {"balanced", "lbvh > treelet(rounds=2, gamma=14) > bvh8",
     "near-best tree for a little more time: the default"},
    {"better", "trysplit > lbvh > treelet(rounds=2, gamma=14) > reinsert > bvh8",
     "splits triangles if rays gain, on the CPU alone: for tens of rays a triangle"},
    {"best", "trysbvh > lbvh > treelet(rounds=2, gamma=14) > reinsert > bvh8",
     "spatial splits if rays gain, on the CPU alone: for billions of rays"},
}};

}  // namespace

std::span<const RecipeWord> recipe_words() { return kWords; }
std::span<const Preset> presets() { return kPresets; }

std::string_view kind_name(WordKind kind) {
  constexpr std::array<std::string_view, 4> names{"splitter", "builder", "optimizer", "layout"};
  return names[std::size_t(kind)];
}

}  // namespace treelet

// Forecasts of whether culling pays, for cameras of three kinds.
#include "session/prospects.h"
#include "tools/cli_runner.h"

#include <nlohmann/json.hpp>

namespace occlude::tools {
namespace {

Occlusion per_frame(uint64_t items, uint64_t owners, uint64_t triangles, uint64_t owner_triangles)
{
    return {10, 10 * items, 10 * owners, 10 * triangles, 10 * owner_triangles};
}

TEST(Judge, GoesByWhatCanBeSavedAndByTheSizeOfFrames)
{
    EXPECT_EQ(judge(per_frame(500, 20, 100000, 50000)), Pays::yes);
    EXPECT_EQ(judge(per_frame(500, 20, 100000, 50001)), Pays::perhaps);
    EXPECT_EQ(judge(per_frame(500, 20, 100000, 80000)), Pays::perhaps);
    EXPECT_EQ(judge(per_frame(500, 20, 100000, 80001)), Pays::no);
    EXPECT_EQ(judge(per_frame(500, 20, 49999, 10)), Pays::small);
    EXPECT_EQ(judge(per_frame(1000, 20, 49999, 10)), Pays::yes) << "many draws are not small";
    EXPECT_EQ(judge(per_frame(500, 0, 100000, 0)), Pays::nothing);
}

TEST(Conclusion, SaysWhichCamerasCullingPaysForAndWhatToDo)
{
    std::vector<Prospect> all{{"inside", ""}, {"street", ""}, {"outside", ""}};
    const auto when = [&](Pays inside, Pays street, Pays outside) {
        all[0].pays = inside;
        all[1].pays = street;
        all[2].pays = outside;
        return conclusion(all);
    };
    EXPECT_NE(when(Pays::yes, Pays::yes, Pays::no)
                  .find("(inside, street), and less or not at all "
                        "for others (outside)"),
              std::string::npos);
    EXPECT_NE(when(Pays::yes, Pays::no_such_path, Pays::yes).find("Culling pays (inside, outside)"),
              std::string::npos);
    EXPECT_NE(when(Pays::no, Pays::perhaps, Pays::no).find("Measure before you integrate"),
              std::string::npos);
    EXPECT_NE(when(Pays::no, Pays::no, Pays::no).find("see nearly everything"), std::string::npos);
    EXPECT_NE(when(Pays::nothing, Pays::no_such_path, Pays::nothing).find("Nothing is proven"),
              std::string::npos);
    EXPECT_NE(when(Pays::small, Pays::no_such_path, Pays::small).find("too small"),
              std::string::npos);
}

TEST(Prospects, ATownPaysFromTheStreetAndSaysSoInWordsAndJson)
{
    const std::string json = (fs::path{write_file("any", "")}.parent_path() / "info.json").string();
    const Outcome outcome = run({"info", "city:triangles=200k,blocks=5", "--device", "cpu",
                                 "--size", "320x180", "--frames", "3", "--json", json});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("walks at eye height"), std::string::npos) << outcome.out;
    const auto document = nlohmann::json::parse(std::ifstream{json});
    ASSERT_EQ(document["cameras"].size(), 3u);
    const auto& street = document["cameras"][1];
    EXPECT_EQ(street["kind"], "street");
    EXPECT_EQ(street["pays"], "yes") << document.dump(1);
    EXPECT_EQ(street["frames"], 3);
    EXPECT_GT(street["limit"], 2.0);
    EXPECT_LT(street["items_seen"], street["items"]);
    EXPECT_LT(document["cameras"][2]["limit"], street["limit"]) << "from outside one sees more";
    EXPECT_NE(outcome.out.find(document["conclusion"].get<std::string>()), std::string::npos);
    for (const auto& change : document["changes"]) {
        EXPECT_NE(outcome.out.find(change["sentence"].get<std::string>()), std::string::npos);
    }
}

TEST(Prospects, AWallAndWhatIsBehindItAreTooSmallAndHaveNoFloors)
{
    const Outcome outcome = run(small({"info", scene_file()}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("no floors or streets"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("the scene is too small"), std::string::npos) << outcome.out;
}

} // namespace
} // namespace occlude::tools

#include "render/image.h"

#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <filesystem>

namespace occlude::tools {
namespace {

Image two_by_three()
{
    return {{2, 3}, {0xff000001u, 0xff000200u, 0xff030000u, 0xff040404u, 0xff050505u, 0xff0607ffu}};
}

TEST(Image, PngHasRowZeroAtTheBottom)
{
    const std::string path = testing::TempDir() + "occlude_image_test.png";
    const auto written = write_png(path, two_by_three());
    ASSERT_TRUE(written) << written.error().message;
    int width = 0;
    int height = 0;
    int channels = 0;
    unsigned char* pixels = stbi_load(path.c_str(), &width, &height, &channels, 0);
    ASSERT_NE(pixels, nullptr);
    ASSERT_EQ(width, 2);
    ASSERT_EQ(height, 3);
    ASSERT_EQ(channels, 3);
    const std::vector<int> bytes(pixels, pixels + 18);
    EXPECT_EQ(bytes, (std::vector<int>{5, 5, 5, 255, 7, 6, 0, 0, 3, 4, 4, 4, 1, 0, 0, 0, 2, 0}));
    stbi_image_free(pixels);
    std::filesystem::remove(path);
}

TEST(Image, UnwritablePathIsAnErrorThatNamesIt)
{
    const auto written = write_png("/no-such-folder/picture.png", two_by_three());
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("/no-such-folder/picture.png"), std::string::npos);
}

TEST(Image, EmptyImageIsAnError)
{
    EXPECT_FALSE(write_png(testing::TempDir() + "occlude_empty.png", Image{}));
    EXPECT_FALSE(write_png(testing::TempDir() + "occlude_empty.png", Image{{2, 2}, {1u}}));
}

TEST(Image, ShrinksByTheMeanOfWholeBlocks)
{
    // To at most 2 pixels wide: by blocks of 3 x 3, and the last two columns are cut off.
    Image image{{5, 6}, std::vector<uint32_t>(30, 0xff000000u)};
    for (size_t i = 0; i < image.pixels.size(); ++i) {
        image.pixels[i] |= i % 5 == 0 ? 90u : 0u; // red in the first column
    }
    const Image small = shrunk(image, 2);
    EXPECT_EQ(small.size, (glm::ivec2{1, 2}));
    EXPECT_EQ(small.pixels, std::vector<uint32_t>(2, 0xff00001eu)); // a third of 90
    EXPECT_EQ(shrunk(image, 5).pixels, image.pixels);
}

TEST(Image, DifferencesAreCountedPerPixel)
{
    const Image a = two_by_three();
    Image b = a;
    EXPECT_EQ(count_differences(a, b), 0u);
    b.pixels[1] ^= 0x00010000u;
    b.pixels[5] = 0;
    EXPECT_EQ(count_differences(a, b), 2u);
    EXPECT_EQ(count_differences(a, Image{{1, 1}, {0u}}), 6u);
}

} // namespace
} // namespace occlude::tools

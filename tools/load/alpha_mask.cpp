#include "load/alpha_mask.h"

#include <fmt/format.h>

#include <stb_image.h>

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

namespace occlude::tools {
namespace {

using nlohmann::json;

constexpr int64_t kLargestSide = 16384; // texels

Bytes image_bytes(GltfDocument& document, GltfAccessors& accessors, const json& texture)
{
    // A texture with an extension (WebP, Basis) may have a PNG or JPEG to fall back to.
    if (!texture.contains("source")) {
        throw GltfError{"its image is in a format that this program does not decode"};
    }
    const json& image = document.entry("images", index_of(texture, "source"));
    const std::string uri = text_of(image, "uri");
    return uri.empty() ? accessors.buffer_view(index_of(image, "bufferView"))
                       : document.uri_bytes(uri);
}

bool repeats(const json* sampler, const char* axis)
{
    constexpr uint32_t kRepeat = 10497;
    constexpr uint32_t kMirroredRepeat = 33648;
    const uint32_t wrap = sampler != nullptr ? index_or(*sampler, axis, kRepeat) : kRepeat;
    return wrap == kRepeat || wrap == kMirroredRepeat;
}

} // namespace

AlphaMask::AlphaMask(GltfDocument& document, GltfAccessors& accessors, const json& material)
{
    const auto cutoff = static_cast<float>(number_or(material, "alphaCutoff", 0.5));
    float factor = 1.0f;
    const auto pbr = material.find("pbrMetallicRoughness");
    const bool has_pbr = pbr != material.end() && pbr->is_object();
    if (has_pbr && pbr->contains("baseColorFactor") && (*pbr)["baseColorFactor"].size() == 4) {
        factor = (*pbr)["baseColorFactor"][3].get<float>();
    }
    const auto info = has_pbr ? pbr->find("baseColorTexture") : json::const_iterator{};
    if (!has_pbr || info == pbr->end()) {
        constant_ = factor >= cutoff ? Coverage::all : Coverage::none;
        return;
    }
    read_texture(document, accessors, *info, factor, cutoff);
}

void AlphaMask::read_texture(GltfDocument& document, GltfAccessors& accessors, const json& info,
                             float factor, float cutoff)
{
    texcoord_ = index_or(info, "texCoord", 0);
    if (const json* transform = extension_of(info, "KHR_texture_transform")) {
        texcoord_ = index_or(*transform, "texCoord", texcoord_);
        rotation_ = static_cast<float>(number_or(*transform, "rotation", 0.0));
        for (int i = 0; i < 2; ++i) {
            const auto axis = static_cast<size_t>(i);
            if (transform->contains("offset")) {
                offset_[i] = transform->at("offset").at(axis).get<float>();
            }
            if (transform->contains("scale")) {
                scale_[i] = transform->at("scale").at(axis).get<float>();
            }
        }
    }
    const json& texture = document.entry("textures", index_of(info, "index"));
    const json* sampler = texture.contains("sampler")
                              ? &document.entry("samplers", index_of(texture, "sampler"))
                              : nullptr;
    repeats_u_ = repeats(sampler, "wrapS");
    repeats_v_ = repeats(sampler, "wrapT");
    const Bytes bytes = image_bytes(document, accessors, texture);
    int width = 0;
    int height = 0;
    int channels = 0;
    const auto size = static_cast<int>(std::min<size_t>(bytes.size(), INT32_MAX));
    if (stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 0 || width <= 0 ||
        height <= 0 || width > kLargestSide || height > kLargestSide) {
        throw GltfError{"its image is no PNG or JPEG of at most 16384 texels a side"};
    }
    document.charge(uint64_t{8} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height));
    constexpr int kRgba = 4;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels{
        stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, kRgba),
        stbi_image_free};
    if (!pixels) {
        throw GltfError{fmt::format("its image cannot be decoded ({})", stbi_failure_reason())};
    }
    width_ = width;
    height_ = height;
    sum_up(pixels.get(), factor, cutoff);
}

void AlphaMask::sum_up(const uint8_t* rgba, float factor, float cutoff)
{
    sums_.assign(static_cast<size_t>((width_ + 1) * (height_ + 1)), 0);
    const auto at = [this](int64_t x, int64_t y) {
        return static_cast<size_t>(y * (width_ + 1) + x);
    };
    for (int64_t y = 0; y < height_; ++y) {
        for (int64_t x = 0; x < width_; ++x) {
            const float alpha =
                factor * static_cast<float>(rgba[4 * (y * width_ + x) + 3]) / 255.0f;
            sums_[at(x + 1, y + 1)] = sums_[at(x, y + 1)] + sums_[at(x + 1, y)] - sums_[at(x, y)] +
                                      (alpha < cutoff ? 1u : 0u);
        }
    }
}

uint64_t AlphaMask::cut_texels(int64_t x_begin, int64_t x_end, int64_t y_begin, int64_t y_end) const
{
    const auto at = [this](int64_t x, int64_t y) {
        return uint64_t{sums_[static_cast<size_t>(y * (width_ + 1) + x)]};
    };
    return at(x_end, y_end) + at(x_begin, y_begin) - at(x_begin, y_end) - at(x_end, y_begin);
}

glm::vec2 AlphaMask::placed(const glm::vec2& uv) const
{
    const float cosine = std::cos(rotation_);
    const float sine = std::sin(rotation_);
    const glm::vec2 scaled = scale_ * uv;
    return offset_ +
           glm::vec2{cosine * scaled.x + sine * scaled.y, cosine * scaled.y - sine * scaled.x};
}

Coverage AlphaMask::coverage(const glm::vec2& a, const glm::vec2& b, const glm::vec2& c) const
{
    if (width_ == 0) {
        return constant_;
    }
    const glm::vec2 p = placed(a);
    const glm::vec2 q = placed(b);
    const glm::vec2 r = placed(c);
    const glm::vec2 low = glm::min(p, glm::min(q, r));
    const glm::vec2 high = glm::max(p, glm::max(q, r));
    // The texels between the two, and one more on each side; all of an axis where it wraps.
    const auto range = [](float from, float to, int64_t size, bool wraps, int64_t& begin,
                          int64_t& end) {
        begin = 0;
        end = size;
        if (!(std::abs(from) < 1e6f && std::abs(to) < 1e6f)) {
            return;
        }
        const float tile = wraps ? std::floor(from) : 0.0f;
        const auto first =
            static_cast<int64_t>(std::floor((from - tile) * static_cast<float>(size))) - 1;
        const auto last =
            static_cast<int64_t>(std::floor((to - tile) * static_cast<float>(size))) + 2;
        if (!wraps || (first >= 0 && last <= size)) {
            begin = std::clamp<int64_t>(first, 0, size - 1);
            end = std::clamp<int64_t>(last, begin + 1, size);
        }
    };
    int64_t x_begin = 0;
    int64_t x_end = 0;
    int64_t y_begin = 0;
    int64_t y_end = 0;
    range(low.x, high.x, width_, repeats_u_, x_begin, x_end);
    range(low.y, high.y, height_, repeats_v_, y_begin, y_end);
    const uint64_t cut = cut_texels(x_begin, x_end, y_begin, y_end);
    const auto all = static_cast<uint64_t>((x_end - x_begin) * (y_end - y_begin));
    return cut == 0 ? Coverage::all : cut == all ? Coverage::none : Coverage::some;
}

} // namespace occlude::tools

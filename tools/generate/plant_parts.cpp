#include "generate/plant_parts.h"

#include "generate/plant_shapes.h"

#include <array>

namespace occlude::tools {

Mesh make_plant_part(PlantPart part, uint32_t elements, uint64_t seed)
{
    constexpr uint32_t kWhole = 0xffffffffu;
    MeshBuilder builder;
    switch (part) {
    case PlantPart::boiler:
        plant::make_boiler(builder, elements);
        break;
    case PlantPart::bundle:
        plant::make_bundle(builder, elements);
        break;
    case PlantPart::rack:
        plant::make_rack(builder, elements, seed);
        break;
    case PlantPart::vessel:
        plant::make_vessel(builder, elements, 1.9f, 4.4f);
        break;
    case PlantPart::machine:
        plant::make_machine(builder, elements);
        break;
    case PlantPart::trays:
        plant::make_trays(builder, elements, seed);
        break;
    case PlantPart::stairs:
        plant::make_stairs(builder, elements);
        break;
    case PlantPart::grating:
        plant::make_grating(builder, elements);
        break;
    case PlantPart::frame:
        plant::make_frame(builder, elements);
        break;
    case PlantPart::cladding:
        plant::make_cladding(builder, elements);
        break;
    case PlantPart::pipework:
        plant::make_pipework(builder, elements, seed);
        break;
    case PlantPart::tank:
    case PlantPart::count:
        plant::make_vessel(builder, elements, 4.5f, 9.0f);
        break;
    }
    return builder.take(plant_part_name(part), kWhole);
}

float plant_part_weight(PlantPart part)
{
    constexpr std::array<float, static_cast<size_t>(PlantPart::count)> kWeights{
        2.5f, 2.5f, 2.0f, 1.0f, 1.2f, 2.0f, 1.0f, 0.7f, 0.4f, 0.3f, 1.5f, 1.0f};
    return kWeights[static_cast<size_t>(part)];
}

const char* plant_part_name(PlantPart part)
{
    constexpr std::array<const char*, static_cast<size_t>(PlantPart::count)> kNames{
        "boiler", "tube bundle", "pipe rack", "vessel",   "machine",  "cable trays",
        "stairs", "grating",     "frame",     "cladding", "pipework", "tank"};
    return kNames[static_cast<size_t>(part)];
}

} // namespace occlude::tools

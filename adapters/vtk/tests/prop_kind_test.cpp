#include "prop_kind.h"

#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkCompositeDataDisplayAttributes.h>
#include <vtkCompositePolyDataMapper2.h>
#include <vtkCubeSource.h>
#include <vtkFollower.h>
#include <vtkImageData.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>
#include <vtkTexture.h>
#include <vtkVolume.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

struct Cube {
    vtkNew<vtkPolyData> surface;
    vtkNew<vtkPolyDataMapper> mapper;
    vtkNew<vtkActor> actor;

    Cube()
    {
        const vtkNew<vtkCubeSource> source;
        source->Update();
        surface->DeepCopy(source->GetOutput());
        mapper->SetInputData(surface);
        actor->SetMapper(mapper);
    }
    PropKind kind() { return kind_of(*actor); }
};

TEST(PropKind, OpaqueSurfacesAreTestable)
{
    Cube cube;
    EXPECT_EQ(cube.kind(), PropKind::testable);
    cube.actor->GetProperty()->BackfaceCullingOn();
    EXPECT_EQ(cube.kind(), PropKind::testable);
}

TEST(PropKind, ActorsThatDrawOutsideOfTheirBoxAreKept)
{
    Cube wireframe;
    wireframe.actor->GetProperty()->SetRepresentationToWireframe();
    EXPECT_EQ(wireframe.kind(), PropKind::kept);
    Cube edges;
    edges.actor->GetProperty()->EdgeVisibilityOn();
    EXPECT_EQ(edges.kind(), PropKind::kept);
    Cube lines;
    const vtkNew<vtkCellArray> line;
    line->InsertNextCell({0, 1});
    lines.surface->SetLines(line);
    EXPECT_EQ(lines.kind(), PropKind::kept);
    Cube shader;
    shader.actor->GetShaderProperty()->AddFragmentShaderReplacement("//VTK::Light::Impl", true, "",
                                                                    false);
    EXPECT_EQ(shader.kind(), PropKind::kept);
    const vtkNew<vtkFollower> follower;
    follower->SetMapper(Cube{}.mapper);
    EXPECT_EQ(kind_of(*follower), PropKind::kept);
}

TEST(PropKind, OffsetsTowardTheViewerAreKept)
{
    vtkMapper::SetResolveCoincidentTopologyToPolygonOffset();
    Cube forward;
    forward.mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(-5.0, -5.0);
    EXPECT_EQ(forward.kind(), PropKind::kept);
    Cube away;
    EXPECT_EQ(away.kind(), PropKind::testable);
    vtkMapper::SetResolveCoincidentTopologyToOff();
    EXPECT_EQ(forward.kind(), PropKind::testable);
}

TEST(PropKind, WhatDrawsNothingOpaqueIsAbsent)
{
    Cube glass;
    glass.actor->GetProperty()->SetOpacity(0.5);
    EXPECT_EQ(glass.kind(), PropKind::absent);
    EXPECT_EQ(kind_of(*vtkNew<vtkActor>()), PropKind::absent);
    EXPECT_EQ(kind_of(*vtkNew<vtkVolume>()), PropKind::absent);
}

TEST(PropKind, WhatMayBlendOrDoAnythingIsOrdered)
{
    Cube forced;
    forced.actor->GetProperty()->SetOpacity(0.5);
    forced.actor->ForceOpaqueOn();
    EXPECT_EQ(forced.kind(), PropKind::ordered);
    EXPECT_EQ(kind_of(*vtkNew<vtkActor2D>()), PropKind::ordered);

    Cube leaf;
    const vtkNew<vtkImageData> image;
    image->SetDimensions(2, 2, 1);
    image->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
    for (int texel = 0; texel < 4; ++texel) {
        auto* color = static_cast<unsigned char*>(image->GetScalarPointer(texel % 2, texel / 2, 0));
        color[3] = texel == 0 ? 0 : 255;
    }
    const vtkNew<vtkTexture> texture;
    texture->SetInputData(image);
    leaf.actor->SetTexture(texture);
    EXPECT_EQ(leaf.kind(), PropKind::testable); // texels are there or not
    texture->MipmapOn();
    EXPECT_EQ(leaf.kind(), PropKind::ordered);
    texture->MipmapOff();
    texture->InterpolateOn();
    EXPECT_EQ(leaf.kind(), PropKind::absent); // translucent
}

TEST(PropKind, CompositesAreTestableUnlessTheirBlocksDiffer)
{
    Cube first;
    Cube second;
    const vtkNew<vtkMultiBlockDataSet> blocks;
    blocks->SetBlock(0, first.surface);
    blocks->SetBlock(1, second.surface);
    const vtkNew<vtkCompositePolyDataMapper2> mapper;
    mapper->SetInputDataObject(blocks);
    const vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    EXPECT_EQ(kind_of(*actor), PropKind::testable);
    EXPECT_EQ(leaves_of(*mapper).size(), 2u);
    const vtkNew<vtkCompositeDataDisplayAttributes> looks;
    mapper->SetCompositeDataDisplayAttributes(looks);
    EXPECT_EQ(kind_of(*actor), PropKind::testable);
    looks->SetBlockVisibility(second.surface, false);
    EXPECT_EQ(kind_of(*actor), PropKind::kept);
}

} // namespace
} // namespace occlude

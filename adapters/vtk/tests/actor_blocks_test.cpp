#include "actor_blocks.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkSphereSource.h>

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace occlude {
namespace {

vtkSmartPointer<vtkPolyData> make_ball()
{
    const vtkNew<vtkSphereSource> source;
    source->SetThetaResolution(50);
    source->SetPhiResolution(50);
    source->Update();
    auto ball = vtkSmartPointer<vtkPolyData>::New();
    ball->DeepCopy(source->GetOutput());
    return ball;
}

std::multiset<std::vector<vtkIdType>> polygons_of(vtkPolyData& surface)
{
    std::multiset<std::vector<vtkIdType>> polygons;
    for (vtkIdType cell = 0; cell < surface.GetPolys()->GetNumberOfCells(); ++cell) {
        vtkIdType count = 0;
        const vtkIdType* corners = nullptr;
        surface.GetPolys()->GetCellAtId(cell, count, corners);
        polygons.emplace(corners, corners + count);
    }
    return polygons;
}

TEST(ActorBlocks, CutIntoPartsThatHoldEachPolygonOnceAndShareThePoints)
{
    const auto ball = make_ball();
    std::multiset<std::vector<vtkIdType>> all;
    const auto blocks = cut(*ball, 300);
    for (const auto& block : blocks) {
        EXPECT_EQ(block->GetPoints(), ball->GetPoints());
        EXPECT_EQ(block->GetPointData()->GetNormals(), ball->GetPointData()->GetNormals());
        EXPECT_LE(block->GetPolys()->GetNumberOfCells(), 300);
        all.merge(polygons_of(*block));
    }
    EXPECT_GT(blocks.size(), 10u);
    EXPECT_EQ(all, polygons_of(*ball));
}

TEST(ActorBlocks, PlacedBoundsHoldEveryPlacedPoint)
{
    const vtkNew<vtkActor> actor;
    actor->SetPosition(10, -20, 5);
    actor->RotateWXYZ(33, 1, 2, 3);
    actor->SetScale(2, 0.5, -3);
    const Bounds bounds = placed_by(*actor, {-1, 2, -3, 4, 5, 6});
    for (int corner = 0; corner < 8; ++corner) {
        const double point[4] = {corner & 1 ? 2.0 : -1.0, corner & 2 ? 4.0 : -3.0,
                                 corner & 4 ? 6.0 : 5.0, 1.0};
        double placed[4];
        actor->GetMatrix()->MultiplyPoint(point, placed);
        for (size_t axis = 0; axis < 3; ++axis) {
            EXPECT_GE(placed[axis], bounds[2 * axis] - 1e-12);
            EXPECT_LE(placed[axis], bounds[2 * axis + 1] + 1e-12);
        }
    }
}

// An actor over a ball, and the number of blocks that it has after some frames.
struct CutActor {
    vtkSmartPointer<vtkPolyData> ball = make_ball();
    vtkNew<vtkPolyDataMapper> mapper;
    vtkNew<vtkActor> actor;
    ActorBlocks blocks;

    CutActor()
    {
        mapper->SetInputData(ball);
        actor->SetMapper(mapper);
        blocks.set_block_triangles(300);
    }
    size_t after(int frames)
    {
        size_t count = 0;
        for (int frame = 0; frame < frames; ++frame) {
            blocks.begin_frame();
            count = blocks.blocks_of(*actor, 5000).size();
        }
        return count;
    }
};

TEST(ActorBlocks, CutAnActorThatStaysTheSameAndDropTheBlocksWhenItChanges)
{
    CutActor cut_actor;
    EXPECT_EQ(cut_actor.after(1), 0u);
    EXPECT_GT(cut_actor.after(5), 10u);
    cut_actor.ball->GetPoints()->SetPoint(0, 0, 0, 9);
    cut_actor.ball->GetPoints()->Modified();
    EXPECT_EQ(cut_actor.after(1), 0u);
    EXPECT_GT(cut_actor.after(5), 10u);
    cut_actor.actor->SetPosition(1, 2, 3); // moves with its blocks
    EXPECT_GT(cut_actor.after(1), 10u);
}

TEST(ActorBlocks, CutNoActorWhoseColorsDependOnTheCutting)
{
    CutActor of_points;
    const vtkNew<vtkFloatArray> values;
    values->SetNumberOfTuples(of_points.ball->GetNumberOfPoints());
    of_points.ball->GetPointData()->SetScalars(values);
    EXPECT_EQ(of_points.after(6), 0u);
    of_points.mapper->ScalarVisibilityOff();
    EXPECT_GT(of_points.after(6), 10u);

    CutActor of_cells;
    const vtkNew<vtkFloatArray> normals;
    normals->SetNumberOfComponents(3);
    normals->SetNumberOfTuples(of_cells.ball->GetNumberOfPolys());
    of_cells.ball->GetCellData()->SetNormals(normals);
    EXPECT_EQ(of_cells.after(6), 0u);
}

TEST(ActorBlocks, CutNoActorWithFewTriangles)
{
    CutActor cut_actor;
    cut_actor.blocks.set_block_triangles(2500);
    EXPECT_EQ(cut_actor.after(6), 0u);
}

} // namespace
} // namespace occlude

#include "random_world.h"

#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCompositePolyDataMapper2.h>
#include <vtkCubeSource.h>
#include <vtkImageData.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPlaneSource.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSphereSource.h>
#include <vtkTexture.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>

#include <algorithm>
#include <cmath>

namespace occlude {

namespace {

// Things stand in cells of a grid and walls between them, so that no two surfaces touch: where they
// do, a pixel shows what was drawn last.
constexpr double kCell = 5.0;
constexpr int kCells = 24; // along a side
constexpr double kHalfWorld = 0.5 * kCells * kCell;
constexpr int kOddActors = 28;
constexpr int kOddKinds = 7;

vtkSmartPointer<vtkPolyData> copy_of(vtkPolyDataAlgorithm& source)
{
    source.Update();
    auto copy = vtkSmartPointer<vtkPolyData>::New();
    copy->DeepCopy(source.GetOutput());
    return copy;
}

vtkSmartPointer<vtkPolyData> box_of_size(double x, double y, double z)
{
    const vtkNew<vtkCubeSource> cube;
    cube->SetBounds(-x, x, -y, y, 0.0, z);
    return copy_of(*cube);
}

vtkSmartPointer<vtkPolyDataMapper> mapper_of(vtkPolyData& surface)
{
    auto mapper = vtkSmartPointer<vtkPolyDataMapper>::New();
    mapper->SetInputData(&surface);
    return mapper;
}

// Texels are opaque or not there.
vtkSmartPointer<vtkTexture> make_mask()
{
    const vtkNew<vtkImageData> image;
    image->SetDimensions(8, 8, 1);
    image->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
    for (int y = 0; y < 8; ++y) {
        for (int x = 0; x < 8; ++x) {
            auto* texel = static_cast<unsigned char*>(image->GetScalarPointer(x, y, 0));
            texel[0] = static_cast<unsigned char>(30 * x);
            texel[1] = static_cast<unsigned char>(30 * y);
            texel[2] = 90;
            texel[3] = (x + y) % 2 == 0 ? 255 : 0;
        }
    }
    auto mask = vtkSmartPointer<vtkTexture>::New();
    mask->SetInputData(image);
    return mask;
}

} // namespace

RandomWorld::RandomWorld(const WorldOptions& options)
    : options_(options)
    , rng_(options.seed)
{
    for (int i = 0; i < kCells * kCells; ++i) {
        free_places_.emplace_back((i / kCells + 0.5) * kCell - kHalfWorld,
                                  (i % kCells + 0.5) * kCell - kHalfWorld, rng_.range(0.1f, 0.4f));
    }
    shared_ = mapper_of(*make_box(1.0f));
    add_walls();
    for (int i = 0; i < options_.things; ++i) {
        random_thing();
        if (options_.odd_actors && i % 10 == 0 && i / 10 < kOddActors) {
            add_odd_actor(i / 10);
        }
    }
    eye_ = free_places_.front() + glm::dvec3(0, 0, 1.7);
}

void RandomWorld::add_to(vtkRenderer& renderer)
{
    renderers_.emplace_back(&renderer);
    for (const auto& actor : actors_) {
        renderer.AddActor(actor);
    }
}

void RandomWorld::add(vtkActor* actor)
{
    actors_.emplace_back(actor);
    for (const auto& renderer : renderers_) {
        renderer->AddActor(actor);
    }
}

vtkSmartPointer<vtkPolyData> RandomWorld::make_box(float half_size)
{
    return box_of_size(half_size, half_size * rng_.range(0.3f, 1.0f),
                       half_size * rng_.range(0.5f, 3.0f));
}

// The middle of a free cell, a little above the ground.
glm::dvec3 RandomWorld::take_place()
{
    const size_t index = rng_.below(static_cast<uint32_t>(free_places_.size()));
    const glm::dvec3 place = free_places_[index];
    free_places_[index] = free_places_.back();
    free_places_.pop_back();
    return place;
}

vtkSmartPointer<vtkActor> RandomWorld::make_actor(vtkPolyData& box, const glm::dvec3& place)
{
    auto actor = vtkSmartPointer<vtkActor>::New();
    actor->SetMapper(mapper_of(box));
    actor->SetPosition(place.x, place.y, place.z);
    actor->RotateZ(static_cast<double>(rng_.range(0.0f, 360.0f)));
    actor->GetProperty()->SetColor(static_cast<double>(rng_.range(0.1f, 1.0f)),
                                   static_cast<double>(rng_.range(0.1f, 1.0f)),
                                   static_cast<double>(rng_.range(0.1f, 1.0f)));
    if (rng_.below(3) == 0) {
        actor->GetProperty()->BackfaceCullingOn();
    }
    return actor;
}

// One wall to a row of cells, as thin as the room that things leave.
void RandomWorld::add_walls()
{
    add(make_actor(*box_of_size(2 * kHalfWorld, 2 * kHalfWorld, 0.02), {0, 0, -1}));
    for (int row = 1; row < kCells; ++row) {
        const auto wall =
            make_actor(*box_of_size(static_cast<double>(rng_.range(5.0f, 25.0f)), 0.2, 8.0),
                       {rng_.range(static_cast<float>(-kHalfWorld), static_cast<float>(kHalfWorld)),
                        row * kCell - kHalfWorld, 0.05});
        wall->SetOrientation(0, 0, 0);
        add(wall);
    }
}

vtkSmartPointer<vtkActor> RandomWorld::random_thing()
{
    const uint32_t kind = rng_.below(10);
    const auto box = make_box(rng_.range(0.2f, 1.5f));
    const auto actor = make_actor(*box, take_place());
    if (kind < 3) {
        actor->SetMapper(shared_);
    }
    if ((kind == 2 || kind == 6) && options_.moves) {
        movers_.push_back(actor);
    }
    if (kind == 5 && options_.comes_and_goes) {
        switched_.push_back(actor);
    }
    if (kind == 7 && options_.deforms) {
        deformers_.push_back(box);
    }
    things_.push_back(actor);
    add(actor);
    return actor;
}

// Actors that cannot be culled, or need care.
void RandomWorld::add_odd_actor(int number)
{
    const auto actor = make_actor(*make_box(1.0f), take_place());
    vtkProperty& looks = *actor->GetProperty();
    switch (number % kOddKinds) {
    case 0:
        looks.SetOpacity(options_.translucent ? 0.5 : 1.0);
        break;
    case 1:
        looks.SetRepresentationToWireframe();
        looks.SetLineWidth(3.0f);
        break;
    case 2:
        looks.EdgeVisibilityOn();
        break;
    case 3: {
        const vtkNew<vtkPlaneSource> plane;
        plane->SetOrigin(-1, 0, 0);
        plane->SetPoint1(1, 0, 0);
        plane->SetPoint2(-1, 0, 2);
        actor->SetMapper(mapper_of(*copy_of(*plane)));
        actor->SetTexture(make_mask());
        break;
    }
    case 4: {
        const vtkNew<vtkMultiBlockDataSet> blocks;
        for (unsigned int i = 0; i < 5; ++i) {
            const vtkNew<vtkSphereSource> ball;
            ball->SetRadius(0.2);
            ball->SetCenter(0.0, 0.0, 0.3 + 0.5 * i);
            blocks->SetBlock(i, copy_of(*ball));
        }
        const vtkNew<vtkCompositePolyDataMapper2> mapper;
        mapper->SetInputDataObject(blocks);
        actor->SetMapper(mapper);
        break;
    }
    case 5: {
        const vtkNew<vtkSphereSource> ball; // smooth normals, many triangles
        ball->SetThetaResolution(40);
        ball->SetPhiResolution(40);
        ball->SetCenter(0.0, 0.0, 1.0);
        actor->SetMapper(mapper_of(*copy_of(*ball)));
        break;
    }
    default:
        if (number == 6 && options_.translucent) { // one alone: it parts the others in two
            looks.SetOpacity(0.6);
            actor->ForceOpaqueOn();
        }
        break;
    }
    add(actor);
}

void RandomWorld::advance()
{
    for (const auto& mover : movers_) {
        if (rng_.below(10) == 0) { // to another cell; else it only turns
            const double* from = mover->GetPosition();
            free_places_.emplace_back(from[0], from[1], from[2]);
            const glm::dvec3 place = take_place();
            mover->SetPosition(place.x, place.y, place.z);
        }
        mover->RotateZ(static_cast<double>(rng_.range(0.0f, 30.0f)));
    }
    for (const auto& actor : switched_) {
        if (rng_.below(8) == 0) {
            actor->SetVisibility(actor->GetVisibility() == 0 ? 1 : 0);
        }
    }
    for (const auto& box : deformers_) {
        const double stretch = static_cast<double>(rng_.range(0.8f, 1.25f));
        vtkPoints& points = *box->GetPoints();
        for (vtkIdType i = 0; i < points.GetNumberOfPoints(); ++i) {
            std::array<double, 3> at{};
            points.GetPoint(i, at.data());
            points.SetPoint(i, at[0], at[1], at[2] * stretch);
        }
        points.Modified();
        box->Modified();
    }
    if (options_.comes_and_goes && rng_.below(2) == 0) {
        const uint32_t index = rng_.below(static_cast<uint32_t>(things_.size()));
        const vtkSmartPointer<vtkActor> gone = things_[index];
        for (const auto& renderer : renderers_) {
            renderer->RemoveActor(gone);
        }
        std::erase(things_, gone);
        std::erase(movers_, gone);
        std::erase(switched_, gone);
        std::erase(actors_, gone);
        const double* place = gone->GetPosition();
        free_places_.emplace_back(place[0], place[1], place[2]);
        random_thing();
    }
}

void RandomWorld::look(vtkCamera& camera)
{
    const bool outside = std::max(std::abs(eye_.x), std::abs(eye_.y)) > 0.8 * kHalfWorld;
    if (outside || rng_.below(25) == 0) {
        heading_ = static_cast<double>(rng_.range(0.0f, 6.3f));
        eye_ = free_places_[rng_.below(static_cast<uint32_t>(free_places_.size()))] +
               glm::dvec3(0, 0, 1.7);
    }
    heading_ += static_cast<double>(rng_.range(-0.2f, 0.2f));
    const glm::dvec3 ahead(std::cos(heading_), std::sin(heading_),
                           static_cast<double>(rng_.range(-0.05f, 0.05f)));
    eye_ += glm::dvec3(ahead.x, ahead.y, 0.0) * 0.6;
    const glm::dvec3 target = eye_ + ahead;
    camera.SetPosition(eye_.x, eye_.y, eye_.z);
    camera.SetFocalPoint(target.x, target.y, target.z);
    camera.SetViewUp(0, 0, 1);
    camera.SetViewAngle(60.0);
    camera.SetClippingRange(0.5, 300.0);
}

} // namespace occlude

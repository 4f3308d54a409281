// VTK: the height is a scalar on the points. It is contoured one plane at a time through a span-space tree, and the
// stripper joins the lines. VTK's plane cutters are faster by themselves but lose loops.
#include <cstdlib>
#include <optional>
#include <vector>

#include <vtkCellArray.h>
#include <vtkCleanPolyData.h>
#include <vtkContourFilter.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkSpanSpace.h>
#include <vtkStripper.h>
#include <vtkVersion.h>

#include "peer.hpp"

namespace {

using namespace lamella::peers;  // NOLINT(google-build-using-namespace)

/// Merges equal points and stores their heights.
vtkSmartPointer<vtkPolyData> mesh_of(const Problem& problem) {
    const auto triangles = static_cast<vtkIdType>(problem.triangles());
    vtkNew<vtkPoints> points;
    points->SetNumberOfPoints(3 * triangles);
    vtkNew<vtkCellArray> cells;
    cells->AllocateExact(triangles, 3 * triangles);
    for (vtkIdType t = 0; t < triangles; ++t) {
        cells->InsertNextCell({3 * t, 3 * t + 1, 3 * t + 2});
        for (vtkIdType corner = 3 * t; corner < 3 * t + 3; ++corner) {
            points->SetPoint(corner, &problem.soup[static_cast<std::size_t>(3 * corner)]);
        }
    }
    vtkNew<vtkPolyData> soup;
    soup->SetPoints(points);
    soup->SetPolys(cells);
    vtkNew<vtkCleanPolyData> clean;
    clean->SetInputData(soup);
    clean->ToleranceIsAbsoluteOn();
    clean->SetAbsoluteTolerance(0);
    clean->ConvertPolysToLinesOff();
    clean->Update();
    vtkSmartPointer<vtkPolyData> mesh = clean->GetOutput();
    vtkNew<vtkFloatArray> heights;
    heights->SetNumberOfValues(mesh->GetNumberOfPoints());
    for (vtkIdType p = 0; p < mesh->GetNumberOfPoints(); ++p) {
        heights->SetValue(p, static_cast<float>(mesh->GetPoint(p)[2]));
    }
    mesh->GetPointData()->SetScalars(heights);
    return mesh;
}

/// A pipeline with its own mesh and tree. If two threads share a mesh, contours sometimes come out in pieces.
class Pipeline {
public:
    explicit Pipeline(vtkPolyData* mesh) {
        mesh_->DeepCopy(mesh);
        mesh_->BuildCells();
        tree_->SetDataSet(mesh_);
        tree_->SetScalars(mesh_->GetPointData()->GetScalars());
        tree_->BuildTree();
        contour_->SetInputData(mesh_);
        contour_->ComputeNormalsOff();
        contour_->ComputeScalarsOff();
        contour_->UseScalarTreeOn();
        contour_->SetScalarTree(tree_);
        stripper_->SetInputConnection(contour_->GetOutputPort());
        stripper_->SetMaximumLength(longest_polyline);
        stripper_->JoinContiguousSegmentsOn();
    }

    vtkSmartPointer<vtkPolyData> cut(double height_mm) {
        contour_->SetValue(0, height_mm);
        stripper_->Update();
        const auto contours = vtkSmartPointer<vtkPolyData>::New();
        contours->ShallowCopy(stripper_->GetOutput());
        return contours;
    }

private:
    static constexpr int longest_polyline = 100000;  // VTK accepts no longer ones
    vtkNew<vtkPolyData> mesh_;
    vtkNew<vtkSpanSpace> tree_;
    vtkNew<vtkContourFilter> contour_;
    vtkNew<vtkStripper> stripper_;
};

Seconds run(const Problem& problem, Counts& counts) {
    const auto start = lamella::Clock::now();
    const vtkSmartPointer<vtkPolyData> mesh = mesh_of(problem);
    std::vector<std::optional<Pipeline>> pipelines(static_cast<std::size_t>(problem.threads));
    const lamella::Parallel parallel({.threads = problem.threads});
    parallel.run(pipelines.size(), [&](std::size_t i, int) { pipelines[i].emplace(mesh); });
    const double build_s = seconds_since(start);
    std::vector<vtkSmartPointer<vtkPolyData>> contours(problem.planes_mm.size());
    parallel.run(contours.size(), [&](std::size_t plane, int worker) {
        contours[plane] = pipelines[static_cast<std::size_t>(worker)]->cut(problem.planes_mm[plane]);
    });
    const double all_s = seconds_since(start);
    counts.reserve(contours.size());
    for (const auto& lines : contours) {
        counts.push_back(static_cast<std::uint64_t>(lines->GetNumberOfLines()));
    }
    return {build_s, all_s - build_s};
}

}  // namespace

int main(int count, char** words) {
    // VTK starts no threads of its own: planes are already shared out to threads. The header that controls this is not
    // valid C++20.
    setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 1);
    return run_peer(run, count, words);
}

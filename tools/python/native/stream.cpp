// Layers in chunks, while a thread slices.
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <optional>

#include "lamella/sink.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

/// Room for `count` more elements after those that are there.
template <class T>
T* grow(Array<T>& array, std::size_t count) {
    const std::size_t size = array.size();
    if (size + count > array.capacity()) {
        Array<T> larger;
        larger.resize_discarding(std::max(size + count, 2 * array.capacity()));
        std::memcpy(static_cast<void*>(larger.data()), array.data(), size * sizeof(T));
        array = std::move(larger);
    }
    array.set_size(size + count);
    return array.data() + size;
}

/// A result of the layers [first, ...) that is being put together.
class Chunk {
public:
    Chunk(const SliceOptions& options, std::uint64_t first_layer) : held_{SliceResult{}, first_layer} {
        held_.result.region = options.region;
        held_.result.close_gaps_mm = options.close_gaps_mm;
        held_.result.gap_sense = options.gap_sense;
        held_.result.frame = options.transform;
        held_.result.plan.side = options.plan.side;
    }

    void add(const LayerView& view) {
        SliceResult& result = held_.result;
        const std::uint64_t first_contour = result.contours.size();
        const std::uint64_t first_point = result.points.size();
        Layer* const layer = grow(result.layers, 1);
        *layer = view.layer;
        layer->first_contour = first_contour;
        Contour* contour = grow(result.contours, view.contours.size());
        for (const Contour& given : view.contours) {
            *contour = given;
            contour->first_point += first_point;
            contour->parent += given.parent < 0 ? 0 : static_cast<std::int64_t>(first_contour);
            count(given, result.summary);
            ++contour;
        }
        std::copy(view.points.begin(), view.points.end(), grow(result.points, view.points.size()));
        std::copy(view.origins.begin(), view.origins.end(), grow(result.origins, view.origins.size()));
        ClosedGap* gap = grow(result.closed_gaps, view.closed_gaps.size());
        for (const ClosedGap& given : view.closed_gaps) {
            *gap = given;
            gap->layer = result.layers.size() - 1;
            ++gap;
        }
        result.unit_mm = view.unit_mm;
        result.summary.segments += view.layer.segments;
        grow_box(view);
    }

    std::uint64_t first_layer() const noexcept { return held_.first_layer; }
    std::size_t layers() const noexcept { return held_.result.layers.size(); }
    HeldResult take() noexcept { return std::move(held_); }

private:
    void grow_box(const LayerView& view) {
        SliceSummary& summary = held_.result.summary;
        for (const Point& point : view.points) {
            const PointMm mm = view.to_mm(point);
            const double at[3] = {mm.x, mm.y, view.layer.plane_mm};
            for (int axis = 0; axis < 3; ++axis) {
                summary.min_mm[axis] = boxed_ ? std::min(summary.min_mm[axis], at[axis]) : at[axis];
                summary.max_mm[axis] = boxed_ ? std::max(summary.max_mm[axis], at[axis]) : at[axis];
            }
            boxed_ = true;
        }
    }

    HeldResult held_;
    bool boxed_ = false;
};

/// A thread slices and waits while a finished chunk has not been taken: two chunks are held at most.
class Slicing {
public:
    Slicing(const py::object& view, SliceOptions options, std::uint64_t chunk_layers)
        : mesh_(view), options_(std::move(options)), chunk_layers_(chunk_layers) {
        const View& meshes = view.cast<const View&>();
        options_.transform = meshes.to_planes(options_.transform);
        options_.control.stop = {[](void* context) noexcept { return static_cast<Slicing*>(context)->closing_.load(); },
                                 this};
        options_.control.executor = executor_here();
        if (options_.control.progress.context != nullptr) {
            report_ = py::reinterpret_borrow<py::object>(static_cast<PyObject*>(options_.control.progress.context));
            options_.control.progress = {
                [](void* context, double fraction) noexcept { static_cast<Slicing*>(context)->reached_.store(fraction); },
                this};
        }
        chunk_.emplace(options_, 0);
        worker_ = std::thread([this, mesh = meshes.mesh()] { work(mesh); });
    }
    Slicing(const Slicing&) = delete;
    Slicing& operator=(const Slicing&) = delete;
    ~Slicing() {
        {
            const std::lock_guard lock(mutex_);
            closing_ = true;
        }
        changed_.notify_all();
        const py::gil_scoped_release released;
        worker_.join();
    }

    /// The next chunk, or None.
    py::object next() {
        Caller caller({});
        std::optional<HeldResult> taken;
        bool interrupted = false;
        {
            const py::gil_scoped_release released;
            std::unique_lock lock(mutex_);
            while (!ready_ && !finished_ && !interrupted) {
                changed_.wait_for(lock, std::chrono::milliseconds(50));
                lock.unlock();
                interrupted = caller.look();
                lock.lock();
            }
            taken = std::exchange(ready_, std::nullopt);
        }
        changed_.notify_all();
        if (interrupted) {
            throw py::error_already_set();
        }
        if (!taken && error_) {
            raise(*error_);
        }
        report(!taken);
        if (!taken) {
            return py::none();
        }
        return py::cast(std::move(*taken));
    }

private:
    /// Before the last chunk has been taken the stream is not done, however far the engine is.
    void report(bool last) {
        const double reached = last ? 1 : std::min(reached_.load(), 0.999);
        if (report_ && reached > reported_) {
            reported_ = reached;
            report_(reached);
        }
    }

    void work(const MeshView& mesh) noexcept {
        const auto take = [this](const LayerView& layer) noexcept { add(layer); };
        const Result<SliceTotals> totals = slice_to(LayerSink::to(take, SinkOrder::ascending), mesh, options_);
        if (totals && !error_ && chunk_->layers() > 0) {
            hand_over();
        }
        const std::lock_guard lock(mutex_);
        if (!totals && !error_) {
            error_ = totals.error();
        }
        finished_ = true;
        changed_.notify_all();
    }

    void add(const LayerView& layer) noexcept {
        if (closing_) {
            return;
        }
        try {
            chunk_->add(layer);
            if (chunk_->layers() == chunk_layers_) {
                hand_over();
            }
        } catch (const std::bad_alloc&) {
            error_ = Error{ErrorCode::out_of_memory, "out of memory for a chunk of layers"};
            closing_ = true;
        }
    }

    void hand_over() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return !ready_ || closing_; });
        const std::uint64_t next_layer = chunk_->first_layer() + chunk_->layers();
        ready_.emplace(chunk_->take());
        chunk_.emplace(options_, next_layer);
        changed_.notify_all();
    }

    py::object mesh_;
    SliceOptions options_;
    std::uint64_t chunk_layers_;
    py::object report_;  // null: none is wanted
    std::atomic<double> reached_{0};
    double reported_ = 0;
    std::atomic<bool> closing_ = false;
    std::optional<Chunk> chunk_;  // the worker's
    std::optional<Error> error_;  // the worker's, until it has finished
    std::mutex mutex_;            // of the two below
    std::optional<HeldResult> ready_;
    bool finished_ = false;
    std::condition_variable changed_;
    std::thread worker_;
};

/// A Slicing, which a forked process leaves alone: its thread is not there, and what it holds locked stays so.
class Stream {
public:
    Stream(const py::object& view, const SliceOptions& options, std::uint64_t chunk_layers)
        : process_(getpid()), slicing_(std::make_unique<Slicing>(view, options, chunk_layers)) {}
    Stream(Stream&&) = default;
    Stream& operator=(Stream&&) = default;
    ~Stream() { close(); }

    py::object next() {
        if (!slicing_) {
            return py::none();
        }
        if (getpid() != process_) {
            raise({ErrorCode::invalid_argument, "a stream cannot go on in a forked process: begin it there"});
        }
        return slicing_->next();
    }

    void close() {
        if (getpid() != process_) {
            static_cast<void>(slicing_.release());
        }
        slicing_.reset();
    }

private:
    pid_t process_;
    std::unique_ptr<Slicing> slicing_;
};

}  // namespace

void define_stream(py::module_& module) {
    py::class_<Stream>(module, "Stream")
        .def(py::init<const py::object&, const SliceOptions&, std::uint64_t>())
        .def("next", &Stream::next)
        .def("close", &Stream::close);
}

}  // namespace lamella::python

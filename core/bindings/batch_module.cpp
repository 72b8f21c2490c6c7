// A Python module that flies batches with one instruction set; omnimorph._core makes what it takes.
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <map>

#include "batch_groups.hpp"
#include "flight_arrays.hpp"
#include "rotor_counts.hpp"

namespace omnimorph::python::OMNIMORPH_SIMD {

namespace {

template <int N> ThreadPool::FlyGroup flyer(const BatchParts& parts, bool single_precision) { return group_flyer<N>(parts, single_precision); }

/// Flights under way, or over: their parts, what came of them, and the threads that fly them.
class Batch {
  public:
    Batch(const PlantSettings<double, 0>& plant, const AnyVehicle& model, const ControllerSettings<double, 0>& controller, const nb::object& reference,
          const Array& starts, const Array& thrust, const Array& tilt, const FlightSettings& settings, const nb::dict& variation,
          const std::vector<long>& recorded, bool single_precision, int threads)
        : reference_(reference) {
        const long flights = static_cast<long>(starts.size() / state_width);
        const int n = model.n_rotors, m = model.n_servos;
        if (flights < 1 || threads < 1) throw nb::value_error("a batch has a flight and a thread at least");
        expect_times(settings.steps, settings.control_every, !recorded.empty());
        expect_size(starts, static_cast<std::size_t>(flights) * state_width, "starts");
        for (long k = 0; k < flights; ++k) starts_.push_back(motion_from(starts.data() + k * state_width));
        sums_.resize(starts_.size());
        status_.resize(starts_.size(), FlightStatus::flying);
        last_step_.resize(starts_.size());
        parts_ = std::make_unique<BatchParts>(BatchParts{plant, model, controller, nb::cast<const Reference*>(reference), command_from(thrust, tilt, n, m),
                                                         settings, flights, starts_.data(),
                                                         variation_from(variation, starts_.size(), static_cast<std::size_t>(n)), {}, sums_.data(),
                                                         status_.data(), last_step_.data()});
        for (const long flight : recorded) {
            columns_[flight] = std::make_shared<Columns>(static_cast<std::size_t>(settings.steps + 1), n, m);
            parts_->recorded.push_back({flight, columns_[flight]->record()});
        }
        const auto fly_group = with_rotors(n, [&](auto rotors) { return group_flyer<rotors>(*parts_, single_precision); });
        crew_ = std::make_unique<ThreadPool>(threads, flights, single_precision ? lanes<float> : lanes<double>, fly_group);
    }

    ThreadPool& threads() { return *crew_; }

    /// One row of sums a flight.
    Numbers sums() const { return new_array(&sums_.front().rows, {sums_.size(), flight_sums}); }
    const std::vector<FlightStatus>& status() const { return status_; }
    long last_step(long flight) const { return last_step_.at(static_cast<std::size_t>(flight)); }
    nb::dict columns(long flight) const { return Columns::arrays(columns_.at(flight)); }

  private:
    Variation variation_from(const nb::dict& arrays, std::size_t flights, std::size_t n) {
        const auto rows = [&](const char* name, std::size_t width) -> const double* {
            if (!arrays.contains(name)) return nullptr;
            const Array array = nb::cast<Array>(arrays[name], false);
            expect_size(array, flights * width, name);
            return varied_.emplace_back(array.data(), array.data() + array.size()).data();
        };
        Variation v;
        v.mass = rows("mass", 1);
        v.inertia = rows("inertia", 1);
        v.thrust_coefficient = rows("thrust_coefficient", n);
        v.drag_coefficient = rows("drag_coefficient", n);
        v.effectiveness = rows("effectiveness", n);
        v.centre_of_mass = rows("centre_of_mass", 3);
        v.rotor_lag = rows("rotor_lag", 1);
        v.noise = rows("noise", 1);
        v.wrench = rows("wrench", 6);
        return v;
    }

    nb::object reference_;  // which the flights read, as they do what follows
    std::vector<std::vector<double>> varied_;
    std::vector<Motion<double>> starts_;
    std::map<long, std::shared_ptr<Columns>> columns_;  // and into these they write
    std::vector<FlightSums> sums_;
    std::vector<FlightStatus> status_;
    std::vector<long> last_step_;
    std::unique_ptr<BatchParts> parts_;
    std::unique_ptr<ThreadPool> crew_;  // the last: its threads end before what they read and write does
};

}  // namespace

void bind_batch(nb::module_& m) {
    using namespace nb::literals;
    m.attr("lanes") = lanes<double>;
    nb::class_<Batch>(m, "Batch")
        .def("wait", [](Batch& b, double seconds) {
            const nb::gil_scoped_release others_go_on;
            return b.threads().wait(seconds);
        }, "seconds"_a)
        .def("stop", [](Batch& b) { b.threads().stop(); })
        .def_prop_ro("done", [](Batch& b) { return b.threads().done(); })
        .def("sums", &Batch::sums)
        .def("status", [](const Batch& b) {
            nb::list all;
            for (const FlightStatus status : b.status()) all.append(static_cast<int>(status));
            return all;
        })
        .def("last_step", &Batch::last_step, "flight"_a)
        .def("columns", &Batch::columns, "flight"_a);
    m.def("start", [](const PlantSettings<double, 0>& plant, const AnyVehicle& model, const ControllerSettings<double, 0>& controller,
                      const nb::object& reference, const Array& starts, const Array& thrust, const Array& tilt, long steps, int control_every,
                      double lost_beyond, std::uint64_t seed, std::uint32_t first, const nb::dict& variation, const std::vector<long>& recorded,
                      bool single_precision, int threads) {
        return std::make_unique<Batch>(plant, model, controller, reference, starts, thrust, tilt,
                                       FlightSettings{steps, control_every, lost_beyond, {seed, first}}, variation, recorded, single_precision, threads);
    }, nb::kw_only(), "plant"_a, "model"_a, "controller"_a, "reference"_a, "starts"_a, "thrust"_a, "tilt"_a, "steps"_a, "control_every"_a, "lost_beyond"_a,
       "seed"_a, "first"_a, "variation"_a, "recorded"_a, "single_precision"_a, "threads"_a);
}

}  // namespace omnimorph::python::OMNIMORPH_SIMD

NB_MODULE(OMNIMORPH_BATCH_MODULE, m) {
    m.doc() = "Flights in batches for one instruction set; its documented face is omnimorph.fly_many.";
    nanobind::set_leak_warnings(false);
    omnimorph::python::OMNIMORPH_SIMD::bind_batch(m);
}

// A Python module that flies batches with one instruction set; omnimorph._core makes what it takes.
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <map>

#include "batch_groups.hpp"
#include "bound_reference.hpp"
#include "bound_settings.hpp"
#include "flight_arrays.hpp"
#include "rotor_counts.hpp"

namespace omnimorph::python::OMNIMORPH_SIMD {

namespace {

/// Flights under way, or over: what they are flown by, what came of them, and the threads that fly them.
class Batch {
  public:
    Batch(const nb::object& settings, const nb::object& reference, long flights, const FlightLimits& limits,
          const nb::dict& variation, const std::vector<long>& recorded, bool single_precision, int threads)
        : settings_(settings), reference_(reference) {
        const AnyLoopSettings& s = nb::cast<const BoundSettings&>(settings).settings;
        const int n = s.controller.model.n_rotors, m = s.controller.model.n_servos;
        if (n == 0 || flights < 1 || threads < 1)
            throw nb::value_error("a batch has a controller, a flight and a thread at least");
        expect_times(limits.steps, s.control_every, !recorded.empty());
        const std::size_t count = static_cast<std::size_t>(flights);
        sums_.resize(count * n_flight_sums);
        status_.resize(count, FlightStatus::flying);
        last_step_.resize(count);
        parts_ = std::make_unique<BatchParts>(BatchParts{s,
                                                         nb::cast<const BoundReference&>(reference).view(),
                                                         limits,
                                                         flights,
                                                         varied_from(s, variation, count),
                                                         {},
                                                         sums_.data(),
                                                         status_.data(),
                                                         last_step_.data()});
        for (const long flight : recorded) {
            columns_[flight] = std::make_shared<RunColumns>(static_cast<std::size_t>(limits.steps + 1), n, m);
            parts_->recorded.push_back({flight, columns_[flight]->record()});
        }
        const auto fly_group =
            with_rotors(n, [&](auto rotors) { return group_flyer<rotors>(*parts_, single_precision); });
        pool_ =
            std::make_unique<ThreadPool>(threads, flights, single_precision ? lanes<float> : lanes<double>, fly_group);
    }

    ThreadPool& pool() { return *pool_; }

    /// One row of sums a flight, in the order of `sum_names`.
    Numbers sums() const { return new_array(sums_.data(), {status_.size(), n_flight_sums}); }
    const std::vector<FlightStatus>& status() const { return status_; }
    long last_step(long flight) const { return last_step_.at(static_cast<std::size_t>(flight)); }
    nb::dict columns(long flight) const { return RunColumns::arrays(columns_.at(flight)); }

  private:
    /// Rows of numbers, one a flight, by the path of what they are.
    std::vector<Varied> varied_from(const AnyLoopSettings& settings, const nb::dict& variation, std::size_t flights) {
        std::vector<Varied> varied;
        const std::vector<FieldPlace> places = places_in(settings);
        for (const auto& [key, value] : variation) {
            const auto path = nb::cast<std::string>(key);
            const auto place =
                std::find_if(places.begin(), places.end(), [&](const FieldPlace& p) { return p.path == path; });
            if (place == places.end()) throw nb::value_error(("settings have no field " + path).c_str());
            if (!place->varies) throw nb::value_error((path + " is the same for all flights of a batch").c_str());
            const auto array = nb::cast<Array>(value, false);
            expect_size(array, flights * place->width, path.c_str());
            numbers_.emplace_back(array.data(), array.data() + array.size());
            varied.push_back({place->at, static_cast<int>(place->width), numbers_.back().data()});
        }
        return varied;
    }

    nb::object settings_, reference_;  // which the flights read, as they do what follows
    std::vector<std::vector<double>> numbers_;
    std::map<long, std::shared_ptr<RunColumns>> columns_;  // and into these they write
    std::vector<double> sums_;
    std::vector<FlightStatus> status_;
    std::vector<long> last_step_;
    std::unique_ptr<BatchParts> parts_;
    std::unique_ptr<ThreadPool> pool_;  // the last: its threads end before what they read and write does
};

std::vector<std::string> sum_names() {
    std::vector<std::string> names;
    for_each_sum(FlightSums<double>{}, [&](const char* name, const auto&) { names.emplace_back(name); });
    return names;
}

}  // namespace

void bind_batch(nb::module_& m) {
    using namespace nb::literals;
    m.attr("lanes") = lanes<double>;
    m.attr("sum_names") = sum_names();
    nb::class_<Batch>(m, "Batch")
        .def(
            "wait",
            [](Batch& b, double seconds) {
                const nb::gil_scoped_release others_go_on;
                return b.pool().wait(seconds);
            },
            "seconds"_a)
        .def("stop", [](Batch& b) { b.pool().stop(); })
        .def_prop_ro("done", [](Batch& b) { return b.pool().done(); })
        .def("sums", &Batch::sums)
        .def("status",
             [](const Batch& b) {
                 nb::list all;
                 for (const FlightStatus status : b.status()) all.append(static_cast<int>(status));
                 return all;
             })
        .def("last_step", &Batch::last_step, "flight"_a)
        .def("columns", &Batch::columns, "flight"_a);
    m.def(
        "start",
        [](const nb::object& settings, const nb::object& reference, long flights, long steps, double lost_beyond,
           std::uint64_t seed, std::uint32_t first, const nb::dict& variation, const std::vector<long>& recorded,
           bool single_precision, int threads) {
            return std::make_unique<Batch>(settings, reference, flights,
                                           FlightLimits{steps, lost_beyond, {seed, first}}, variation, recorded,
                                           single_precision, threads);
        },
        nb::kw_only(), "settings"_a, "reference"_a, "flights"_a, "steps"_a, "lost_beyond"_a, "seed"_a, "first"_a,
        "variation"_a, "recorded"_a, "single_precision"_a, "threads"_a);
}

}  // namespace omnimorph::python::OMNIMORPH_SIMD

NB_MODULE(OMNIMORPH_BATCH_MODULE, m) {
    m.doc() = "Flights in batches for one instruction set; its documented face is omnimorph.fly_many.";
    nanobind::set_leak_warnings(false);
    omnimorph::python::OMNIMORPH_SIMD::bind_batch(m);
}

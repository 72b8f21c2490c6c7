// The controller, and the flight: all in the core, or one control step or physics step at a time.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <memory>
#include <stdexcept>

#include "bind.hpp"
#include "bound_reference.hpp"
#include "bound_settings.hpp"
#include "flight_arrays.hpp"
#include "omnimorph/flight/metrics.hpp"
#include "rotor_counts.hpp"
#include "stored_bytes.hpp"

namespace omnimorph::python {

namespace {

/// From a dict of every field; the model is a vehicle that was made before.
void make_controller_settings(AnyControllerSettings* self, const nb::dict& fields) {
    new (self) AnyControllerSettings{};
    const auto& model = nb::cast<const AnyVehicle&>(fields["model"]);
    Tables none;
    RecordReader(model.n_rotors, model.n_servos, none).read(*self, fields, "controller");
    derive(*self);
    const auto* candidates = std::get_if<TiltCandidates>(&self->allocation.rule);
    if (candidates == nullptr) return;
    if (model.n_servos != 1) throw nb::value_error("a rule that tries tilts needs exactly one servo");
    if (candidates->count < 3 || candidates->count % 2 == 0)
        throw nb::value_error("candidates are odd and three or more");
}

/// An allocation as Python sees it; with the counts of rotors and servos that it holds.
struct AllocationView {
    AnyAllocation a;
    int n, m;
    Numbers thrust{}, tilt{};
};

/// A controller as Python has it: behind a pointer, as it is aligned more strictly than who holds it can know.
struct BoundController {
    std::unique_ptr<AnyController> controller;
    double period;  // s
    Rows thrusts, tilts;
    AnyController* operator->() const { return controller.get(); }
    AllocationView seen(const AnyAllocation& a) {
        return {a, controller->n_rotors, controller->n_servos, thrusts.next(a.command.thrust.a),
                tilts.next(a.command.tilt.a)};
    }
};

/// A flight in the same way, with what it reads and writes; in one thread at a time.
struct BoundFlight {
    nb::object settings, reference;
    std::shared_ptr<RunColumns> columns;  // none, if it is not recorded
    std::unique_ptr<AnyFlight> flight;
    long steps = 0;        // of physics in all
    bool is_away = false;  // flown while other threads of Python go on
    AnyFlight* operator->() const {
        if (is_away) throw std::runtime_error("the flight is being flown in another thread");
        return flight.get();
    }
};

void advance(BoundFlight& f, long most_steps) {
    AnyFlight* const flight = f.operator->();
    f.is_away = true;
    {
        const nb::gil_scoped_release others_go_on;
        flight->advance(most_steps);
    }
    f.is_away = false;
}

/// Thrusts (K, n) and tilts (K, m) of K control steps, one after the other.
std::tuple<Numbers, Numbers> replayed(const BoundController& controller, const Array& states, const Array& desired) {
    const std::size_t K = states.size() / state_width, n = static_cast<std::size_t>(controller->n_rotors),
                      m = static_cast<std::size_t>(controller->n_servos);
    expect_size(states, K * state_width, "states");
    expect_size(desired, K * desired_width, "desired");
    std::vector<Motion<double>> estimates;
    std::vector<Desired<double>> desired_motions;
    for (std::size_t k = 0; k < K; ++k) {
        estimates.push_back(motion_from(states.data() + k * state_width));
        desired_motions.push_back(desired_from(desired.data() + k * desired_width));
    }
    std::vector<double> thrust(K * n), tilt(K * m);
    controller->replay(K, estimates.data(), desired_motions.data(), thrust.data(), tilt.data());
    return {new_array(thrust.data(), {K, n}), new_array(tilt.data(), {K, m})};
}

/// Costs (S, K) of S control steps at K tilts each.
Numbers costs_over_tilt(const AnyControllerSettings& settings, const Array& states, const Array& accelerations,
                        const Array& previous_thrusts, const Array& tilts) {
    const AnyVehicle& vehicle = settings.model;
    if (tilts.ndim() != 2 || vehicle.n_servos != 1)
        throw nb::value_error("cost_over_tilt takes rows of tilts of a single servo");
    const std::size_t S = tilts.shape(0), K = tilts.shape(1), n = static_cast<std::size_t>(int(vehicle.n_rotors));
    expect_size(states, S * state_width, "states");
    expect_size(accelerations, S * 6, "accelerations");
    expect_size(previous_thrusts, S * n, "previous_thrusts");
    std::vector<ControlStep> steps(S);
    for (std::size_t k = 0; k < S; ++k) {
        steps[k] = {motion_from(states.data() + k * state_width), vector_from<6>(accelerations.data() + k * 6), {}};
        for (std::size_t i = 0; i < n; ++i) steps[k].previous_thrust[int(i)] = previous_thrusts.data()[k * n + i];
    }
    const auto costs = with_rotors(
        vehicle.n_rotors, [&](auto rotors) { return cost_over_tilt<rotors>(settings, steps, tilts.data(), K); });
    return new_array(costs.data(), {S, K});
}

BoundController new_controller(const AnyControllerSettings& settings, const Array& thrust, const Array& tilt) {
    const AnyCommand start = command_from(thrust, tilt, settings.model.n_rotors, settings.model.n_servos);
    return {with_rotors(settings.model.n_rotors, [&](auto rotors) { return make_controller<rotors>(settings, start); }),
            settings.period, Rows(settings.model.n_rotors), Rows(settings.model.n_servos)};
}

StateHeader header_of(const BoundController& c) {
    StateHeader header;
    header.kind = StoredKind::controller;
    header.n_rotors = c->n_rotors;
    header.n_servos = c->n_servos;
    header.control_every = 1;
    header.physics_step = c.period;
    return header;
}

BoundFlight new_flight(const nb::object& settings, const nb::object& reference, long steps, double lost_beyond,
                       std::uint64_t seed, std::uint32_t flight, bool is_recorded) {
    const AnyLoopSettings& s = nb::cast<const BoundSettings&>(settings).settings;
    const int n = s.controller.model.n_rotors, m = s.controller.model.n_servos;
    if (n == 0) throw nb::value_error("a flight has a controller");
    expect_times(steps, s.control_every, is_recorded);
    BoundFlight bound{settings, reference, {}, {}, steps};
    if (is_recorded) bound.columns = std::make_shared<RunColumns>(static_cast<std::size_t>(steps + 1), n, m);
    const Record record = is_recorded ? bound.columns->record() : Record();
    const Reference followed = nb::cast<const BoundReference&>(reference).view();
    bound.flight = with_rotors(
        n, [&](auto rotors) { return make_flight<rotors>(s, followed, {steps, lost_beyond, {seed, flight}}, record); });
    return bound;
}

StateHeader header_of(const BoundFlight& flight) {
    StateHeader header;
    header.n_rotors = flight->n_rotors;
    header.n_servos = flight->n_servos;
    const AnyLoopSettings& s = nb::cast<const BoundSettings&>(flight.settings).settings;
    header.control_every = s.control_every;
    header.physics_step = s.plant.step;
    return header;
}

nb::bytes stored(const BoundFlight& flight) {
    const auto delay_line = flight->delay_line();
    return stored_bytes(header_of(flight), flight->state(), delay_line.get());
}

/// Go on from a stored state. Rows of the record before it that this flight has not flown are not numbers.
void restore(const BoundFlight& flight, const nb::bytes& bytes) {
    const auto delay_line = flight->delay_line();
    const FlightState<double, 0> state = stored_state(bytes, header_of(flight), delay_line.get());
    if (state.step > flight.steps) throw nb::value_error("it is broken");
    if (flight.columns) flight.columns->leave_out(flight->step(), state.step);
    flight->restore(state, delay_line.get());
}

/// Send a command that was decided outside; false, and the end of the flight, if a number of it is not finite.
bool decide(const BoundFlight& flight, const Array& thrust, const Array& tilt, const Array& wrench_asked) {
    expect_size(wrench_asked, 6, "wrench_asked");
    AnyAllocation a{command_from(thrust, tilt, flight->n_rotors, flight->n_servos),
                    {},
                    std::nan(""),
                    std::nan(""),
                    vector_from<6>(wrench_asked.data())};
    double sum = 0;
    for (int j = 0; j < flight->n_servos; ++j) sum += a.command.tilt[j];
    for (int i = 0; i < flight->n_rotors; ++i) {
        const double f = a.command.thrust[i];
        sum += f;
        a.active[i] = f >= flight->thrust_max[i] ? 1.0 : (f <= flight->thrust_min[i] ? -1.0 : 0.0);
    }
    if (is_finite(sum)) {
        flight->command(a);
    } else {
        flight->end_here(FlightStatus::not_finite);
    }
    return is_finite(sum);
}

/// Where a plant outside is, so many physics steps under a push later; its thrusts are empty, if it does not say them.
/// Whether all that is finite.
bool place(const BoundFlight& flight, const Array& p, const Array& R, const Array& v, const Array& w,
           const Array& speed, const Array& tilt, const Array& wrench, const Array& thrust, const Array& push,
           int steps_later) {
    expect_size(p, 3, "the position");
    expect_size(R, 9, "the attitude");
    expect_size(v, 3, "the velocity");
    expect_size(w, 3, "the body rate");
    expect_size(wrench, 6, "the wrench");
    expect_size(push, 6, "the push");
    PlantState<double, 0> outside{};
    outside.motion = {vector_from<3>(p.data()), vector_from<3>(v.data()), matrix_from(R.data()),
                      vector_from<3>(w.data())};
    outside.actuators.speed = per_rotor_from(speed, flight->n_rotors, "the speed");
    outside.actuators.tilt = per_servo_from(tilt, flight->n_servos, "the tilt");
    outside.load.wrench = vector_from<6>(wrench.data());
    const bool says_thrust = thrust.size() > 0;
    PerRotor<double, 0> its_thrust{};
    if (says_thrust) its_thrust = per_rotor_from(thrust, flight->n_rotors, "the thrust");
    flight->place(outside, says_thrust ? &its_thrust : nullptr, vector_from<6>(push.data()), steps_later);
    bool finite = true;
    for (const Array* numbers : {&p, &R, &v, &w, &speed, &tilt, &wrench, &thrust})
        for (std::size_t k = 0; k < numbers->size(); ++k) finite = finite && is_finite(numbers->data()[k]);
    return finite;
}

/// Everything of the true state that a part outside may ask for: the motion, the acceleration, speeds and tilts.
Numbers truth(const BoundFlight& flight) {
    double all[state_width + 6 + 2 * most_rotors];
    const FlightState<double, 0> state = flight->state();
    double* next = write(state.plant.motion, all);
    const Vec6<double> acceleration = flight->acceleration();
    next = std::copy_n(acceleration.a, 6, next);
    next = std::copy_n(state.plant.actuators.speed.a, flight->n_rotors, next);
    next = std::copy_n(state.plant.actuators.tilt.a, flight->n_servos, next);
    return new_array(all, {static_cast<std::size_t>(next - all)});
}

/// The sums over the rows of a flight whose columns are kept, by name.
nb::dict sums_of_run(const AnyVehicle& model, const nb::dict& columns, const Array& drag_power, bool is_completed,
                     double physics_step, int control_every, bool single_precision) {
    if (control_every < 1) throw nb::value_error("there is a physics step at least between two commands");
    const Record record = record_from(columns, drag_power.size(), model.n_rotors, model.n_servos);
    const RecordedRows recorded{record,
                                drag_power.data(),
                                static_cast<long>(drag_power.size()),
                                is_completed,
                                physics_step,
                                control_every,
                                single_precision ? box_qp::proven<float> : box_qp::proven<double>};
    nb::dict sums;
    for_each_sum(sums_of(recorded, model),
                 [&](const char* name, const auto& sum) { sums[name] = static_cast<double>(sum); });
    return sums;
}

}  // namespace

void bind_loop(nb::module_& m) {
    using namespace nb::literals;
    nb::class_<AnyControllerSettings>(m, "ControllerSettings").def("__init__", &make_controller_settings, "fields"_a);
    nb::class_<AllocationView>(m, "Allocation")
        .def_prop_ro("thrust",
                     [](const AllocationView& v) { return v.thrust ? v.thrust : new_array(v.a.command.thrust.a, v.n); })
        .def_prop_ro("tilt",
                     [](const AllocationView& v) { return v.tilt ? v.tilt : new_array(v.a.command.tilt.a, v.m); })
        .def_prop_ro("active", [](const AllocationView& v) { return new_array(v.a.active.a, v.n); })
        .def_prop_ro("wrench_asked", [](const AllocationView& v) { return new_array(v.a.wrench_asked.a, 6); })
        .def_prop_ro("cost", [](const AllocationView& v) { return v.a.cost; })
        .def_prop_ro("kkt_residual", [](const AllocationView& v) { return v.a.kkt_residual; });
    nb::class_<BoundController>(m, "Controller")
        .def(
            "step",
            [](BoundController& c, nb::handle state, nb::handle desired) {
                return c.seen(c->step(motion_from(state), desired_from(desired)));
            },
            "state"_a, "desired"_a)
        .def(
            "allocate",
            [](BoundController& c, nb::handle state, nb::handle acceleration) {
                const auto wish = row_from<6>(acceleration, "acceleration");
                return c.seen(c->allocate(motion_from(state), {vector_from<6>(wish.data())}));
            },
            "state"_a, "acceleration"_a)
        .def("replay", &replayed, "states"_a, "desired"_a)
        .def("store", [](const BoundController& c) { return stored_bytes(header_of(c), c->state(), nullptr); })
        .def(
            "restore",
            [](const BoundController& c, const nb::bytes& state) {
                c->restore(stored_state(state, header_of(c), nullptr));
            },
            "state"_a);
    m.def("new_controller", &new_controller, "settings"_a, "thrust"_a, "tilt"_a);
    m.def("cost_over_tilt", &costs_over_tilt, "settings"_a, "states"_a, "accelerations"_a, "previous_thrusts"_a,
          "tilts"_a);
    m.def(
        "reference_acceleration",
        [](const AnyControllerSettings& s, nb::handle state, nb::handle desired) {
            return new_array(reference_acceleration(motion_from(state), desired_from(desired), s.tracking.gains).a,
                             {6});
        },
        "settings"_a, "state"_a, "desired"_a);
    m.def(
        "wrench_for",
        [](const AnyVehicle& v, nb::handle state, nb::handle acceleration) {
            const auto wish = row_from<6>(acceleration, "acceleration");
            return new_array(wrench_for(v, motion_from(state), vector_from<6>(wish.data())).a, 6);
        },
        "vehicle"_a, "state"_a, "acceleration"_a);

    nb::class_<BoundReference>(m, "Reference").def("__init__", &make_reference, "segments"_a, "samples"_a);

    nb::enum_<FlightStatus>(m, "FlightStatus")
        .value("FLYING", FlightStatus::flying)
        .value("COMPLETED", FlightStatus::completed)
        .value("LOST", FlightStatus::lost)
        .value("NOT_FINITE", FlightStatus::not_finite)
        .value("DIVERGED", FlightStatus::diverged)
        .value("PART_FAILED", FlightStatus::part_failed);
    nb::class_<BoundFlight>(m, "Flight")
        .def("advance", &advance, "most_steps"_a)
        .def("measure", [](const BoundFlight& f) { return as_array(f->measure()); })
        .def("motion", [](const BoundFlight& f) { return as_array(f->state().plant.motion); })
        .def("desired", [](const BoundFlight& f) { return as_array(f->desired()); })
        .def("truth", &truth)
        .def("decided",
             [](const BoundFlight& f) { return AllocationView{f->state().decided, f->n_rotors, f->n_servos}; })
        .def("measured", [](const BoundFlight& f) { return as_array(f->measured()); })
        .def(
            "estimate_from",
            [](const BoundFlight& f, const Array& measured) {
                return as_array(f->estimate_from(motion_from(measured)));
            },
            "measured"_a)
        .def(
            "control",
            [](const BoundFlight& f, const Array& state, const Array& desired) {
                return AllocationView{f->control(motion_from(state), desired_from(desired)), f->n_rotors, f->n_servos};
            },
            "state"_a, "desired"_a)
        .def(
            "answer",
            [](const BoundFlight& f, const Array& state, const Array& acceleration) {
                expect_size(acceleration, 6, "the acceleration");
                return AllocationView{f->answer(motion_from(state), {vector_from<6>(acceleration.data())}), f->n_rotors,
                                      f->n_servos};
            },
            "state"_a, "acceleration"_a)
        .def("decide", &decide, "thrust"_a, "tilt"_a, "wrench_asked"_a)
        .def(
            "change_controller",
            [](const BoundFlight& f, const AnyControllerSettings& settings) { f->change_controller(settings); },
            "settings"_a)
        .def(
            "set_effectiveness",
            [](const BoundFlight& f, const Array& share) {
                f->set_effectiveness(per_rotor_from(share, f->n_rotors, "share"));
            },
            "share"_a)
        .def(
            "integrate",
            [](const BoundFlight& f, int steps, const Array& push) {
                expect_size(push, 6, "push");
                f->integrate(steps, vector_from<6>(push.data()));
            },
            "steps"_a, "push"_a)
        .def("finish_row", [](const BoundFlight& f) { return f->finish_row(); })
        .def("place", &place, "p"_a, "R"_a, "v"_a, "w"_a, "speed"_a, "tilt"_a, "wrench"_a, "thrust"_a, "push"_a,
             "steps_later"_a)
        .def(
            "end_here", [](const BoundFlight& f, FlightStatus status) { f->end_here(status); }, "status"_a)
        .def(
            "put_rows",
            [](const BoundFlight& f, const nb::dict& columns) {
                if (f.columns) f.columns->put(columns);
            },
            "columns"_a)
        .def("columns", [](const BoundFlight& f) { return f.columns ? RunColumns::arrays(f.columns) : nb::dict(); })
        .def("store", &stored)
        .def("restore", &restore, "state"_a)
        .def_prop_ro("step", [](const BoundFlight& f) { return f->step(); })
        .def_prop_ro("status", [](const BoundFlight& f) { return f->status(); });
    m.def("sums_of_run", &sums_of_run, nb::kw_only(), "model"_a, "columns"_a, "drag_power"_a, "is_completed"_a,
          "physics_step"_a, "control_every"_a, "single_precision"_a);
    m.attr("LAST_SECOND") = last_second;
    m.def("new_flight", &new_flight, nb::kw_only(), "settings"_a, "reference"_a, "steps"_a, "lost_beyond"_a, "seed"_a,
          "flight"_a, "is_recorded"_a);
}

}  // namespace omnimorph::python

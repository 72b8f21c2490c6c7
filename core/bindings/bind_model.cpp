// Vehicle, wrench map, interference, box QP, noise and the rotation group.
#include <nanobind/stl/array.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bind.hpp"
#include "omnimorph/math/random.hpp"
#include "omnimorph/model/interference.hpp"
#include "records.hpp"

namespace omnimorph::python {

namespace {

/// A vehicle of as many rotors as there are spins, and of as many servos as there are least angles.
AnyVehicle make_vehicle(const nb::dict& fields) {
    const int n = static_cast<int>(nb::cast<Array>(fields["spin"], false).size()),
              m = static_cast<int>(nb::cast<Array>(fields["angle_min"], false).size());
    if (n < 1 || n > most_rotors || m > most_servos)
        throw nb::value_error("a vehicle has 1 to 18 rotors and 0 to 18 servos");
    AnyVehicle v{};
    v.n_rotors = Count<0>(n);
    v.n_servos = m;
    Tables none;
    RecordReader(n, m, none).read(v, fields, "vehicle");
    for (int i = 0; i < n; ++i)
        if (v.servo[i] < 0 || v.servo[i] >= std::max(m, 1))
            throw nb::value_error("a rotor names a servo that the vehicle does not have");
    derive(v);
    return v;
}

PerRotor<double, 0> newtons() {
    PerRotor<double, 0> one;
    for (double& unit : one.a) unit = 1.0;
    return one;
}

Numbers allocation_matrix(const AnyVehicle& v, const Array& tilt) {
    const auto trig = trigonometry_of(per_servo_from(tilt, v.n_servos, "tilt"), v.n_servos);
    const auto A = thrust_wrench_map(v, newtons()).at(trig);
    const int n = v.n_rotors;
    std::vector<double> rows(static_cast<std::size_t>(6 * n));
    for (int r = 0; r < 6; ++r)
        for (int i = 0; i < n; ++i) rows[r * n + i] = A.column[i][r];
    return new_array(rows.data(), {6, static_cast<std::size_t>(n)});
}

/// d(A f)/d(angle of each servo), 6 x m.
Numbers tilt_derivative(const AnyVehicle& v, const Array& thrust, const Array& tilt) {
    const auto trig = trigonometry_of(per_servo_from(tilt, v.n_servos, "tilt"), v.n_servos);
    const auto f = per_rotor_from(thrust, v.n_rotors, "thrust");
    const auto map = thrust_wrench_map(v, newtons());
    const int m = v.n_servos;
    std::vector<double> rows(static_cast<std::size_t>(6 * m));
    for (int i = 0; i < v.n_rotors && m > 0; ++i) {
        const Vec6<double> slope = map.tilt_derivative(i, trig);
        for (int r = 0; r < 6; ++r) rows[r * m + v.servo[i]] += f[i] * slope[r];
    }
    return new_array(rows.data(), {6, static_cast<std::size_t>(m)});
}

/// (above, below) of each pair.
std::vector<std::array<int, 2>> stacked_pairs(const AnyVehicle& v) {
    const Interference<double, 0> interference(v, WakeModel::published);
    std::vector<std::array<int, 2>> pairs;
    for (int p = 0; p < interference.n_pairs(); ++p)
        pairs.push_back({interference.pair(p).above, interference.pair(p).below});
    return pairs;
}

/// The share of its thrust that each rotor loses.
Numbers thrust_lost(const AnyVehicle& v, const Array& tilt, const Array& speed, bool blade_element) {
    const Interference<double, 0> interference(v, blade_element ? WakeModel::blade_element : WakeModel::published);
    const auto trig = trigonometry_of(per_servo_from(tilt, v.n_servos, "tilt"), v.n_servos);
    auto share = interference.thrust_kept(interference.weights(trig), per_rotor_from(speed, v.n_rotors, "speed"));
    for (int i = 0; i < v.n_rotors; ++i) share[i] = 1.0 - share[i];
    return new_array(share.a, {static_cast<std::size_t>(v.n_rotors)});
}

std::tuple<Numbers, Numbers, double, int> solve_box_qp(const Array& H, const Array& g, const Array& lower,
                                                       const Array& upper, const Array& start) {
    const int n = static_cast<int>(g.size());
    constexpr int largest = most_rotors + most_servos;
    if (n < 1 || n > largest) throw nb::value_error("a box QP has 1 to 36 variables");
    expect_size(H, static_cast<std::size_t>(n * n), "H");
    BoxQp<double, largest> qp{};
    for (const Array* each : {&lower, &upper, &start})
        expect_size(*each, static_cast<std::size_t>(n), "lower, upper or start");
    BoxQpSolution<double, largest> s{};
    for (int i = n; i < largest; ++i) qp.H[i][i] = 1;  // those beyond the last stay 0
    for (int i = 0; i < n; ++i) {
        qp.g[i] = g.data()[i];
        qp.lower[i] = lower.data()[i];
        qp.upper[i] = upper.data()[i];
        s.active[i] = start.data()[i];
        for (int j = 0; j < n; ++j) qp.H[i][j] = H.data()[i * n + j];
    }
    solve(qp, s);
    const std::size_t size = static_cast<std::size_t>(n);
    return {new_array(s.x.a, {size}), new_array(s.active.a, {size}), s.kkt_residual, s.iterations};
}

Numbers measurement_normals(std::uint64_t seed, std::uint32_t flight, std::uint32_t first_step, std::uint32_t steps) {
    std::vector<double> rows(std::size_t{12} * steps);
    for (std::uint32_t k = 0; k < steps; ++k)
        for (std::uint32_t pair = 0; pair < 6; ++pair) {
            const auto two = standard_normal_pair({seed, flight}, first_step + k, pair);
            rows[12 * k + 2 * pair] = two[0];
            rows[12 * k + 2 * pair + 1] = two[1];
        }
    return new_array(rows.data(), {steps, 12});
}

}  // namespace

void bind_model(nb::module_& m) {
    using namespace nb::literals;
    nb::class_<AnyVehicle>(m, "Vehicle");
    m.def("make_vehicle", &make_vehicle, "fields"_a);
    m.def("allocation_matrix", &allocation_matrix, "vehicle"_a, "tilt"_a);
    m.def("tilt_derivative", &tilt_derivative, "vehicle"_a, "thrust"_a, "tilt"_a);
    m.def("stacked_pairs", &stacked_pairs, "vehicle"_a);
    m.def("thrust_lost", &thrust_lost, "vehicle"_a, "tilt"_a, "speed"_a, "blade_element"_a);
    m.def("solve_box_qp", &solve_box_qp, "H"_a, "g"_a, "lower"_a, "upper"_a, "start"_a);
    m.def("measurement_normals", &measurement_normals, "seed"_a, "flight"_a, "first_step"_a, "steps"_a);
    m.def(
        "philox",
        [](std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) { return philox(counter, key); },
        "counter"_a, "key"_a);
    m.def(
        "rotation_exponential",
        [](const Array& phi) {
            expect_size(phi, 3, "phi");
            return new_array(exp_so3(vector_from<3>(phi.data())).a[0], {3, 3});
        },
        "phi"_a);
}

}  // namespace omnimorph::python

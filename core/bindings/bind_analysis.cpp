// Wrench sets and the thrusts of least effort.
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bind.hpp"
#include "omnimorph/sets/facets.hpp"
#include "omnimorph/sets/least_effort.hpp"
#include "omnimorph/sets/zonotope.hpp"

namespace omnimorph::python {

namespace {

/// Call `work` with the number of rows, 1 to 6, as a constant.
template <class Work> auto with_rows(std::size_t rows, Work work) {
    switch (rows) {
        case 1:
            return work(std::integral_constant<int, 1>());
        case 2:
            return work(std::integral_constant<int, 2>());
        case 3:
            return work(std::integral_constant<int, 3>());
        case 4:
            return work(std::integral_constant<int, 4>());
        case 5:
            return work(std::integral_constant<int, 5>());
        case 6:
            return work(std::integral_constant<int, 6>());
        default:
            throw nb::value_error("the matrix has 1 to 6 rows");
    }
}

template <int R> std::vector<Vec<double, R>> columns_of(const Array& matrix) {
    const std::size_t n = matrix.shape(1);
    std::vector<Vec<double, R>> columns(n);
    for (int r = 0; r < R; ++r)
        for (std::size_t k = 0; k < n; ++k) columns[k][r] = matrix.data()[r * n + k];
    return columns;
}

/// Unit normals (F, r) and distances (F,) of the hyperplanes on one side; their opposites bound the other.
std::tuple<Numbers, Numbers> bounding_hyperplanes_of(const Array& generators) {
    if (generators.ndim() != 2) throw nb::value_error("generators are the columns of a matrix");
    return with_rows(generators.shape(0), [&](auto rows) {
        constexpr int R = rows;
        const auto g = columns_of<R>(generators);
        std::vector<double> normals, distances;
        bounding_hyperplanes<R>(g.data(), static_cast<int>(g.size()),
                                [&](const Vec<double, R>& normal, double distance) {
                                    normals.insert(normals.end(), normal.a, normal.a + R);
                                    distances.push_back(distance);
                                });
        return std::make_tuple(new_array(normals.data(), {distances.size(), R}),
                               new_array(distances.data(), {distances.size()}));
    });
}

/// Corners (V, 3), the corners of each facet in order, and the halfspace it lies on.
std::tuple<Numbers, std::vector<std::vector<int>>, std::vector<int>> facets_of_halfspaces(const Array& normals,
                                                                                          const Array& distances) {
    const std::size_t count = distances.size();
    expect_size(normals, 3 * count, "normals");
    std::vector<Vec3<double>> n;
    for (std::size_t k = 0; k < count; ++k) n.push_back(vector_from<3>(normals.data() + 3 * k));
    const Facets found = facets_of(n, {distances.data(), distances.data() + count});
    std::vector<double> corners;
    for (const Vec3<double>& x : found.corners) corners.insert(corners.end(), x.a, x.a + 3);
    return {new_array(corners.data(), {found.corners.size(), 3}), found.polygons, found.halfspace};
}

/// Thrusts (K, n), multipliers (K, r), residuals (K,) and outcomes (K,) for K wrenches.
std::tuple<Numbers, Numbers, Numbers, Numbers> least_effort(const Array& matrix, const Array& wrenches,
                                                            const Array& price, const Array& lower, const Array& upper,
                                                            bool power) {
    if (matrix.ndim() != 2 || matrix.shape(1) > most_rotors || wrenches.ndim() != 2 ||
        wrenches.shape(1) != matrix.shape(0))
        throw nb::value_error("least_effort takes a matrix (r, n) and wrenches (K, r), n at most 18");
    const std::size_t n = matrix.shape(1), K = wrenches.shape(0);
    expect_size(price, n, "price");
    expect_size(lower, n, "lower");
    expect_size(upper, n, "upper");
    return with_rows(matrix.shape(0), [&](auto rows) {
        constexpr int R = rows;
        const auto columns = columns_of<R>(matrix);
        LeastEffort<R> problem;
        problem.n = static_cast<int>(n);
        problem.effort = power ? Effort::power : Effort::norm;
        for (std::size_t i = 0; i < n; ++i) {
            problem.column[i] = columns[i];
            problem.price[i] = price.data()[i];
            problem.lower[i] = lower.data()[i];
            problem.upper[i] = upper.data()[i];
        }
        std::vector<double> thrusts, multipliers, residuals, outcomes;
        for (std::size_t k = 0; k < K; ++k) {
            const auto s = solve(problem, vector_from<R>(wrenches.data() + k * R));
            thrusts.insert(thrusts.end(), s.thrust, s.thrust + n);
            multipliers.insert(multipliers.end(), s.multiplier.a, s.multiplier.a + R);
            residuals.push_back(s.residual);
            outcomes.push_back(static_cast<double>(s.outcome));
        }
        return std::make_tuple(new_array(thrusts.data(), {K, n}), new_array(multipliers.data(), {K, R}),
                               new_array(residuals.data(), {K}), new_array(outcomes.data(), {K}));
    });
}

}  // namespace

void bind_analysis(nb::module_& m) {
    using namespace nb::literals;
    m.def("bounding_hyperplanes", &bounding_hyperplanes_of, "generators"_a);
    m.def("facets", &facets_of_halfspaces, "normals"_a, "distances"_a);
    m.def("least_effort", &least_effort, "matrix"_a, "wrenches"_a, "price"_a, "lower"_a, "upper"_a, "power"_a);
}

}  // namespace omnimorph::python

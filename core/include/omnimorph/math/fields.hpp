// What a record is made of, said once: its fields, by name and place. Conversion to other numbers and counts, bindings,
// storage and what may vary from flight to flight follow from the list.
//
//     struct Gains {
//         Vec3<T> position, velocity;
//         static constexpr auto fields() {
//             return field_list(field("position", &Gains::position), field("velocity", &Gains::velocity));
//         }
//     };
//
// A record is an aggregate, so its members can be counted: one that its list forgets does not compile.
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "number.hpp"
#include "records.hpp"

namespace omnimorph {

/// A view of numbers owned elsewhere, which outlive it.
struct Table {
    const double* numbers = nullptr;
    long size = 0;
};

/// One field. A derived one follows from others and is set by `derive`, never from outside.
template <class Record, class Member> struct Field {
    const char* name;
    Member Record::* place;
    bool is_derived;
};
template <class Record, class Member> constexpr Field<Record, Member> field(const char* name, Member Record::* place) {
    return {name, place, false};
}
template <class Record, class Member>
constexpr Field<Record, Member> derived(const char* name, Member Record::* place) {
    return {name, place, true};
}
/// The fields of a record, in order: what takes a function and calls it with all of them. (Lighter to compile than a
/// tuple.)
template <class... Each> constexpr auto field_list(Each... each) {
    return [=](auto&& use) -> decltype(auto) { return use(each...); };
}

namespace fields {

/// Converts to anything, in an operand that is never evaluated.
struct Anything {
    template <class X> operator X() const;
};
template <class Record, class Places, class = void> struct HasMembers : std::false_type {};
template <class Record, std::size_t... I>
struct HasMembers<Record, std::index_sequence<I...>, std::void_t<decltype(Record{(void(I), Anything{})...})>>
    : std::true_type {};

/// Whether an aggregate has so many members, and not more.
template <class Record, std::size_t Count>
inline constexpr bool has_count = HasMembers<Record, std::make_index_sequence<Count>>::value &&
                                  !HasMembers<Record, std::make_index_sequence<Count + 1>>::value;

template <class X, class = void> struct IsRecord : std::false_type {};
template <class X> struct IsRecord<X, std::void_t<decltype(X::fields())>> : std::true_type {};
template <class X> inline constexpr bool is_record = IsRecord<X>::value;

/// Vec, Mat3, PerRotor …: a structure around one array `a`.
template <class X, class = void> struct IsArray : std::false_type {};
template <class X> struct IsArray<X, std::void_t<decltype(std::declval<X&>().a[0])>> : std::true_type {};
template <class X> inline constexpr bool is_array = IsArray<X>::value || std::is_array_v<X>;
template <class X> constexpr auto& elements_of(X& x) {
    if constexpr (std::is_array_v<X>) {
        return x;
    } else {
        return x.a;
    }
}

/// Records of different kinds, all of them there, or one of them.
template <class X> inline constexpr bool is_list = false;
template <class... Each> inline constexpr bool is_list<Records<Each...>> = true;
template <class X> inline constexpr bool is_choice = false;
template <class... Each> inline constexpr bool is_choice<std::variant<Each...>> = true;

struct CountEach {
    template <class... Each> constexpr auto operator()(const Each&...) const {
        return std::integral_constant<std::size_t, sizeof...(Each)>();
    }
};
template <class Record> constexpr std::size_t count() {
    return decltype(Record::fields()(CountEach()))::value;
}
/// Whether no member is listed twice.
struct AllDiffer {
    template <class X, class Y> static constexpr bool differ(const X&, const Y&) { return true; }
    template <class Record, class Member>
    static constexpr bool differ(const Field<Record, Member>& a, const Field<Record, Member>& b) {
        return a.place != b.place;
    }
    constexpr bool operator()() const { return true; }
    template <class Record, class Member, class... Each>
    constexpr bool operator()(const Field<Record, Member>& first, const Each&... rest) const {
        return (differ(first, rest) && ...) && (*this)(rest...);
    }
};
template <class Record> constexpr void expect_every_member() {
    static_assert(has_count<Record, count<Record>()>, "a member is missing in the list of fields");
    static_assert(Record::fields()(AllDiffer()), "a member is listed twice");
}

/// Whether a record has derived fields beside `active`, which is set where the record is read.
struct AnyDerived {
    template <class... Each> constexpr bool operator()(const Each&... each) const {
        return ((each.is_derived && std::string_view(each.name) != "active") || ...);
    }
};
template <class Record> inline constexpr bool has_derived = Record::fields()(AnyDerived());

}  // namespace fields

/// visit(field, member) for every field of a record.
template <class Record, class Visit> constexpr void for_each_field(Record& record, Visit&& visit) {
    using Plain = std::remove_const_t<Record>;
    fields::expect_every_member<Plain>();
    Plain::fields()([&](const auto&... each) { (visit(each, record.*each.place), ...); });
}

/// visit(field of x, field of y) for every field of a record and of its like.
template <class X, class Y, class Visit> constexpr void for_each_pair_of_fields(Visit&& visit) {
    fields::expect_every_member<std::remove_const_t<X>>();
    X::fields()([&](const auto&... of_x) { Y::fields()([&](const auto&... of_y) { (visit(of_x, of_y), ...); }); });
}

/// visit(record of x, record of y) for two lists of records, in order.
template <class Visit> void for_each_pair(Records<>&, const Records<>&, Visit&&) {}
template <class Visit> void for_each_pair(const Records<>&, const Records<>&, Visit&&) {}
template <class X, class Y, class Visit> void for_each_pair(X& x, const Y& y, Visit&& visit) {
    visit(x.first, y.first);
    for_each_pair(x.rest, y.rest, visit);
}

namespace fields {

/// visit(index) for every alternative of a choice, as a constant.
template <class Choice, class Visit, std::size_t... I>
constexpr void for_each_alternative(Visit&& visit, std::index_sequence<I...>) {
    (visit(std::integral_constant<std::size_t, I>()), ...);
}
template <class Choice, class Visit> constexpr void for_each_alternative(Visit&& visit) {
    for_each_alternative<Choice>(visit, std::make_index_sequence<std::variant_size_v<Choice>>());
}

}  // namespace fields

/// visit(path, x, y) for everything in a record that is a number or an array of them, and its like in another: `path`
/// joins the names of the fields by dots. What is derived is left out; a list of records adds no name of its own.
template <class X, class Y, class Visit> void for_each_leaf(const std::string& path, X& x, const Y& y, Visit&& visit) {
    using Plain = std::remove_const_t<X>;
    const auto under = [&](const char* name) { return path.empty() ? std::string(name) : path + "." + name; };
    if constexpr (fields::is_record<Plain>) {
        fields::expect_every_member<Plain>();
        for_each_pair_of_fields<Plain, Y>([&](const auto& of_x, const auto& of_y) {
            constexpr bool adds_a_name = !fields::is_list<std::decay_t<decltype(x.*of_x.place)>>;
            if (of_x.is_derived) return;
            for_each_leaf(adds_a_name ? under(of_x.name) : path, x.*of_x.place, y.*of_y.place, visit);
        });
    } else if constexpr (fields::is_list<Plain>) {
        for_each_pair(x, y, [&](auto& of_x, const auto& of_y) { for_each_leaf(under(of_x.name), of_x, of_y, visit); });
    } else if constexpr (fields::is_choice<Plain>) {
        fields::for_each_alternative<Plain>([&](auto k) {
            if (x.index() != k || y.index() != k) return;
            const char* name = std::variant_alternative_t<k, Plain>::name;
            for_each_leaf(under(name), *std::get_if<k>(&x), *std::get_if<k>(&y), visit);
        });
    } else {
        visit(path, x, y);
    }
}

/// visit(x, y) for every number of one record and its like in another, which may be of other numbers or hold another
/// count of rotors: arrays go together as far as both reach.
template <class X, class Y, class Visit> void for_each_number(X& x, const Y& y, const Visit& visit) {
    if constexpr (fields::is_record<X>) {
        for_each_pair_of_fields<X, Y>(
            [&](const auto& of_x, const auto& of_y) { for_each_number(x.*of_x.place, y.*of_y.place, visit); });
    } else if constexpr (fields::is_list<X>) {
        for_each_pair(x, y, [&](auto& of_x, const auto& of_y) { for_each_number(of_x, of_y, visit); });
    } else if constexpr (fields::is_choice<X>) {
        fields::for_each_alternative<X>([&](auto k) {
            if (y.index() != k) return;
            if (x.index() != k) x.template emplace<k>();
            for_each_number(*std::get_if<k>(&x), *std::get_if<k>(&y), visit);
        });
    } else if constexpr (fields::is_array<X>) {
        auto& to = fields::elements_of(x);
        const auto& from = fields::elements_of(y);
        for (std::size_t k = 0; k < std::min(std::size(to), std::size(from)); ++k)
            for_each_number(to[k], from[k], visit);
    } else {
        visit(x, y);
    }
}

namespace fields {

struct Assign {
    template <class X, class Y> void operator()(X& x, const Y& y) const { x = static_cast<X>(y); }
};
struct AssignLane {
    int index;
    template <class X, class Y> void operator()(X& x, const Y& y) const {
        if constexpr (lane_count<X> > 1) {
            set_lane(x, index, static_cast<Scalar<X>>(y));
        } else {
            x = static_cast<X>(y);
        }
    }
};

}  // namespace fields

/// The same record in other numbers, or for another count of rotors. (Cold: it is done once a flight, and compiles
/// quicker when it need not be quick.)
template <class To, class From> [[gnu::cold, gnu::noinline]] To convert(const From& from) {
    To to{};
    for_each_number(to, from, fields::Assign());
    return to;
}

/// Put a record into one lane of a record of packs; what has no lanes is the same in all of them.
template <class To, class From> [[gnu::cold, gnu::noinline]] void put_lane(To& to, int index, const From& from) {
    for_each_number(to, from, fields::AssignLane{index});
}

/// Whether each lane may have its own numbers in it: an array of packs, or a pack.
template <class X> constexpr bool has_lanes() {
    if constexpr (fields::is_array<X>) {
        using Element = decltype(fields::elements_of(std::declval<X&>())[0]);
        return has_lanes<std::remove_cv_t<std::remove_reference_t<Element>>>();
    } else {
        return lane_count<X> > 1;
    }
}

}  // namespace omnimorph

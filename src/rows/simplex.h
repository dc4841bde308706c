#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace furrow::rows {

/// Minimum of `f` by the downhill simplex of Nelder and Mead (1965), standard coefficients. `start` with one
/// step length per parameter; a parameter with step 0 stays. Stops after `max_calls` or when the simplex's
/// values differ by less than `tolerance`.
template <std::size_t N, class F>
std::array<double, N> minimise_simplex(const F& f, const std::array<double, N>& start,
                                       const std::array<double, N>& step, int max_calls, double tolerance) {
  struct Vertex {
    std::array<double, N> x;
    double value;
  };
  std::array<Vertex, N + 1> simplex;
  simplex[0] = {start, f(start)};
  std::size_t count = 1;  // vertices in use: only parameters with a step span the simplex
  for (std::size_t i = 0; i < N; ++i) {
    if (step[i] == 0.0) continue;
    auto x = start;
    x[i] += step[i];
    simplex[count++] = {x, f(x)};
  }
  if (count == 1) return start;
  const auto begin = simplex.begin(), end = begin + static_cast<std::ptrdiff_t>(count);
  const auto by_value = [](const Vertex& a, const Vertex& b) { return a.value < b.value; };
  const auto sort = [&] {  // by insertion: the vertices are few and nearly in order
    for (std::size_t i = 1; i < count; ++i)
      for (std::size_t j = i; j > 0 && by_value(simplex[j], simplex[j - 1]); --j)
        std::swap(simplex[j], simplex[j - 1]);
  };
  int calls = static_cast<int>(count);
  while (calls < max_calls) {
    sort();
    Vertex& worst = simplex[count - 1];
    if (worst.value - simplex[0].value < tolerance) break;
    std::array<double, N> centroid{};
    for (std::size_t j = 0; j + 1 < count; ++j)
      for (std::size_t i = 0; i < N; ++i) centroid[i] += simplex[j].x[i] / static_cast<double>(count - 1);
    const auto probe = [&](double factor) {
      Vertex vertex{};
      for (std::size_t i = 0; i < N; ++i) vertex.x[i] = centroid[i] + factor * (worst.x[i] - centroid[i]);
      vertex.value = f(vertex.x);
      ++calls;
      return vertex;
    };
    const Vertex reflected = probe(-1.0);
    if (reflected.value < simplex[0].value) {
      const Vertex expanded = probe(-2.0);
      worst = expanded.value < reflected.value ? expanded : reflected;
    } else if (reflected.value < simplex[count - 2].value) {
      worst = reflected;
    } else {
      const Vertex contracted = probe(reflected.value < worst.value ? -0.5 : 0.5);
      if (contracted.value < std::min(reflected.value, worst.value)) {
        worst = contracted;
      } else {
        for (std::size_t j = 1; j < count; ++j) {
          for (std::size_t i = 0; i < N; ++i) simplex[j].x[i] = 0.5 * (simplex[j].x[i] + simplex[0].x[i]);
          simplex[j].value = f(simplex[j].x);
          ++calls;
        }
      }
    }
  }
  return std::min_element(begin, end, by_value)->x;
}

}  // namespace furrow::rows

// Serves rays to a tracer in C++: reads a scene and its rays from a file, and traces parts of them on request.
//
// The file holds a count of triangles, their corners, 0 for closest hits or 1 for any hits, a count of rays, and for
// each ray its origin, its direction and its t_max: counts as 64-bit integers, numbers as doubles. The program prints
// "ready" once the tree stands. Then it answers each line "FROM TO" by tracing those rays and printing "done", and the
// line "answers" by writing a 32-bit triangle for each ray, -1 for a miss, to the file's path with ".answers" added.
#pragma once

#include <array>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

struct Ray {
  std::array<double, 3> origin, dir;
  double t_max;
};

using Corners = std::array<std::array<double, 3>, 3>;

template <typename T>
std::vector<T> read(std::ifstream& file) {
  std::uint64_t count = 0;
  file.read(reinterpret_cast<char*>(&count), sizeof count);
  std::vector<T> all(file ? count : 0);
  file.read(reinterpret_cast<char*>(all.data()), all.size() * sizeof(T));
  return all;
}

// Runs the program of a tracer. `Tracer` is built from the triangles and returns a triangle's index, or -1, from
// `closest(ray)`, and whether there is a hit from `any(ray)`.
template <typename Tracer>
int serve(int count, char** arguments) {
  if (count != 2) return std::cerr << "usage: " << arguments[0] << " FILE\n", 2;
  std::string path = arguments[1];
  std::ifstream file(path, std::ios::binary);
  auto triangles = read<Corners>(file);
  std::uint64_t any = 0;
  file.read(reinterpret_cast<char*>(&any), sizeof any);
  auto rays = read<Ray>(file);
  if (!file) return std::cerr << path << ": cut short\n", 1;

  Tracer tracer(triangles);
  using Prepared = decltype(tracer.prepare(rays[0]));
  std::vector<Prepared> prepared;
  prepared.reserve(rays.size());
  for (const Ray& ray : rays) prepared.push_back(tracer.prepare(ray));
  std::vector<std::int32_t> answers(rays.size(), -1);
  std::cout << "ready" << std::endl;
  for (std::string word; std::cin >> word; std::cout << "done" << std::endl) {
    if (word == "answers") {
      std::ofstream out(path + ".answers", std::ios::binary);
      out.write(reinterpret_cast<const char*>(answers.data()), answers.size() * sizeof answers[0]);
      continue;
    }
    std::size_t from = std::stoull(word), to = 0;
    if (!(std::cin >> to) || from > to || to > rays.size()) return std::cerr << "no such rays\n", 1;
    for (std::size_t i = from; i < to; ++i)
      answers[i] = any ? (tracer.any(prepared[i]) ? 0 : -1) : tracer.closest(prepared[i]);
  }
  return 0;
}

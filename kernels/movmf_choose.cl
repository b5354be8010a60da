// SPDX-License-Identifier: Apache-2.0
// Fits level 1 of maps with even sides, without EM. A texel covers four normals, and each normal belongs wholly to one
// of its lobes. Of all J^4 assignments, the kernel chooses the one with the narrowest lobes. The width of a lobe is
// measured twice: by itself, and mixed with the surrounding lobes as texture filters mix them
// (docs/contributing/ALGORITHMS.md, "Level 1").
//
// For any set of normals, let c be the sum of weights, m = sum n and q = sum |n|^2. Then sqrt(c q - |m|^2) is c times
// their root mean square distance from their mean. For lobes j with normals S_j and surroundings T_j, an assignment
// costs
//
//   sum_j width(S_j) + alignment * width(S_j and T_j),   width = sqrt(c q - |m|^2 + c^2 e)
//
// where e is half the inverse of the cap of kappa. This width is too small to be visible in any highlight. T_j is the
// mean of lobe j over the parents and over the neighbours that are already fitted. The parents are weighted as by a
// filter between levels. The difference c q - |m|^2 is a sum over pairs of normals, and is computed from these pairs.
// If rounding makes the difference negative, its magnitude is still far below e.
//
// The assignment of least cost is found one lobe after another. The least cost of giving the normals S to the first j
// lobes is a minimum over the subsets A of S: lobe j takes the normals A, and the first j - 1 lobes take the other
// normals at their least cost.

#include "device/done_neighbours.clh"
#include "device/level_window.clh"
#include "device/movmf_em.clh"
#include "shared/movmf_choose.h"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#define NORMALS MULTUM_CHOICE_NORMALS
#define SUBSETS (1 << NORMALS)
#define PARENTS 4

// Counts the four bits, because not every compiler's library has popcount().
static int normals_in(int set) { return (set & 1) + ((set >> 1) & 1) + ((set >> 2) & 1) + ((set >> 3) & 1); }

// Returns the window index of the first finest texel that a texel covers in its first row, or in its second row if
// `below` is set.
static size_t covered_pair(int column, int row, int below, const MultumMovmfFit* fit) {
  return map_row_start(2 * row + below, fit) + 2 * column;
}

// Loads one coordinate of the normals of texels. Sample i is in column i % 2 and row i / 2.
static void gather_covered(__global const float* values, const size_t* upper, const size_t* lower, real_v* samples) {
  float4 of_lanes[MULTUM_VECTOR_WIDTH];
#pragma unroll
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane)
    of_lanes[lane] =
        (float4)(values[upper[lane]], values[upper[lane] + 1], values[lower[lane]], values[lower[lane] + 1]);
  transpose(of_lanes, samples, samples + 1, samples + 2, samples + 3);
}

static void gather_normals(__global const float* normal_x, __global const float* normal_y,
                           __global const float* normal_z, const Places* places, const MultumMovmfFit* fit,
                           LobeLanes* samples) {
  size_t upper[MULTUM_VECTOR_WIDTH], lower[MULTUM_VECTOR_WIDTH];
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    upper[lane] = covered_pair(places->column[lane], places->row[lane], 0, fit);
    lower[lane] = covered_pair(places->column[lane], places->row[lane], 1, fit);
  }
  real_v x[NORMALS], y[NORMALS], z[NORMALS];
  gather_covered(normal_x, upper, lower, x);
  gather_covered(normal_y, upper, lower, y);
  gather_covered(normal_z, upper, lower, z);
  for (int i = 0; i < NORMALS; ++i) {
    TO_SAMPLE(real_v, x[i], y[i], z[i], fit->shortened)
    samples[i].x = x[i];
    samples[i].y = y[i];
    samples[i].z = z[i];
    samples[i].amplitude = (real_v)(1.0f);
  }
}

// The parents that a texture filter mixes at the middle of a texel, with weights of 3/4 and 1/4 along each side. The
// texel's own parent is first.
typedef struct Parents {
  int place[PARENTS][MULTUM_VECTOR_WIDTH];
} Parents;

__constant const float parent_weights[PARENTS] = {0.5625f, 0.1875f, 0.1875f, 0.0625f};

// Returns the row or column of parents that is next to `own` on the side of texel `i`. Returns `own` at a border that
// does not repeat.
static int parent_beside(int i, int own, int size, int periodic) {
  const int beside = own + ((i & 1) != 0 ? 1 : -1);
  if (beside >= 0 && beside < size) return beside;
  return periodic ? (beside < 0 ? size - 1 : 0) : own;
}

static void find_parents(const Places* places, const MultumMovmfFit* fit, Parents* parents) {
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    const int column = places->column[lane], row = places->row[lane];
    const int own_column = min(column >> 1, fit->parent_width - 1), own_row = min(row >> 1, fit->parent_height - 1);
    const int columns[2] = {own_column, parent_beside(column, own_column, fit->parent_width, fit->periodic_x)};
    const int rows[2] = {own_row, parent_beside(row, own_row, fit->parent_height, fit->periodic_y)};
    for (int p = 0; p < PARENTS; ++p)
      parents->place[p][lane] =
          row_in_window(rows[p / 2], fit->parent_first_row, fit->parent_height) * fit->parent_width + columns[p % 2];
  }
}

// Sums the lobes that have the same index over the surroundings of each texel. `parent` and `level` are the planes of
// that lobe.
static LobeLanes sums_around(__global const float* parent, __global const float* level, const Places* places,
                             const Parents* parents) {
  LobeLanes sums;
  sums.x = sums.y = sums.z = sums.amplitude = (real_v)(0.0f);
  for (int p = 0; p < PARENTS; ++p) {
    LobeLanes lobe = gather(parent, parents->place[p]);
    lobe.amplitude = MAX_V(lobe.amplitude, (real_v)(MULTUM_CHOICE_AMPLITUDE_MIN));
    const LobeLanes own = sums_of_lobe(lobe);
    const real_v weight = (real_v)(MULTUM_CHOICE_PARENT * parent_weights[p]);
    sums.x += weight * own.x;
    sums.y += weight * own.y;
    sums.z += weight * own.z;
    sums.amplitude += weight * own.amplitude;
  }
  real_v count = (real_v)(MULTUM_CHOICE_PARENT);
  for (int n = 0; n < places->beside_max; ++n) {
    const LobeLanes own = sums_of_lobe(gather(level, places->beside[n]));
    const int_v is_there = has_neighbour(places, n);
    sums.x += is_there ? own.x : (real_v)(0.0f);
    sums.y += is_there ? own.y : (real_v)(0.0f);
    sums.z += is_there ? own.z : (real_v)(0.0f);
    sums.amplitude += is_there ? own.amplitude : (real_v)(0.0f);
    count += is_there ? (real_v)(1.0f) : (real_v)(0.0f);
  }
  const real_v scale = NORMALS * MULTUM_CHOICE_AROUND / count;
  sums.x *= scale;
  sums.y *= scale;
  sums.z *= scale;
  sums.amplitude *= scale;
  return sums;
}

// Computes the scatters c q - |m|^2 of all sets of samples.
static void scatters_of_sets(const LobeLanes* samples, real_v* scatters) {
  scatters[0] = (real_v)(0.0f);
#pragma unroll
  for (int i = 0; i < NORMALS; ++i) {
    const real_v own = sample_scatter(samples[i]);
#pragma unroll
    for (int others = 0; others < SUBSETS; ++others) {
      if (others >= (1 << i)) continue;
      real_v sum = scatters[others] + own;
#pragma unroll
      for (int k = 0; k < i; ++k)
        if ((others >> k) & 1) sum += squared_distance(samples[i], samples[k]) + (own + sample_scatter(samples[k]));
      scatters[others | (1 << i)] = sum;
    }
  }
}

// Computes the cost of giving each set to lobe j.
static void costs_of_sets(const LobeLanes* samples, const real_v* scatters, const real_v* own_costs, LobeLanes around,
                          float e, float alignment, real_v* costs) {
  const real_v square = square_of_sums(around);
  const real_v own = fma(around.amplitude, square, -sample_product(around, around));
  real_v between[SUBSETS];  // scatter of the set's means about the mean of the surroundings
  between[0] = (real_v)(0.0f);
#pragma unroll
  for (int i = 0; i < NORMALS; ++i) {
    const real_v one = fma(sample_square(samples[i]), around.amplitude,
                           fma((real_v)(-2.0f), sample_product(samples[i], around), square));
#pragma unroll
    for (int others = 0; others < SUBSETS; ++others)
      if (others < (1 << i)) between[others | (1 << i)] = between[others] + one;
  }
#pragma unroll
  for (int set = 0; set < SUBSETS; ++set) {
    const real_v weight = around.amplitude + (float)normals_in(set);
    const real_v mixed = scatters[set] + own + between[set];
    costs[set] = fma((real_v)(alignment), sqrt(fma(weight * weight, (real_v)(e), mixed)), own_costs[set]);
  }
}

// Spreads the four bits of a set to four nibbles, one per normal. Each nibble contains the number of the normal's lobe.
static int nibbles(int set) { return (set & 1) | (set & 2) << 3 | (set & 4) << 6 | (set & 8) << 9; }

// One work-item handles MULTUM_VECTOR_WIDTH slots. The global size is slot_count / MULTUM_VECTOR_WIDTH.
//   normal_x, normal_y, normal_z [map_window_rows * map_width]
//   parent     [lobe][parent_window_rows * parent_width]
//   level      [lobe][window_rows * width]   done neighbours read; the texels' lobes written
//   texel_list [slot]                        window row * width + x, or -1
//   chosen     [slot]                        written: the lobe of normal i in bits 4 i to 4 i + 3, for
//                                            movmf_feature_chosen
// fit.alignment is the weight of the mixed widths. Bound by the gathers and by 16 square roots per lobe.
__kernel void movmf_choose(__global const float* normal_x, __global const float* normal_y,
                           __global const float* normal_z, __global const MultumVmfLobe* parent,
                           __global MultumVmfLobe* level, __global const int* texel_list, __global int* chosen,
                           MultumMovmfFit fit) {
  const int slot = (int)get_global_id(0) * MULTUM_VECTOR_WIDTH;
  if (slot >= fit.slot_count) return;
  const size_t level_size = level_window_size(&fit), parent_size = parent_window_size(&fit);
  const float e = 0.5f / fit.kappa_cap;
  Places places;
  find_places(texel_list + slot, &fit, &places);
  Parents parents;
  find_parents(&places, &fit, &parents);
  LobeLanes samples[NORMALS];
  gather_normals(normal_x, normal_y, normal_z, &places, &fit, samples);
  real_v scatters[SUBSETS], own_costs[SUBSETS], costs[SUBSETS], least[SUBSETS];
  int_v lobes[SUBSETS];  // assignments of least cost, in the format of `chosen`
  scatters_of_sets(samples, scatters);
  for (int set = 0; set < SUBSETS; ++set) {
    const float count = (float)normals_in(set);
    own_costs[set] = sqrt(scatters[set] + e * count * count);
    least[set] = (real_v)(0.0f);
    lobes[set] = (int_v)(0);
  }
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    const LobeLanes around = sums_around((__global const float*)(parent + j * parent_size),
                                         (__global const float*)(level + j * level_size), &places, &parents);
    costs_of_sets(samples, scatters, own_costs, around, e, fit.alignment, costs);
    if (j == 0) {
      for (int set = 0; set < SUBSETS; ++set) least[set] = costs[set];
      continue;
    }
    // Starts with the largest set, because a set's cost depends on smaller sets, whose costs must not have changed yet.
    // The last lobe needs only the set of all normals.
    const int smallest = j == MULTUM_LOBES - 1 ? SUBSETS - 1 : 0;
#pragma unroll
    for (int set = SUBSETS - 1; set >= 0; --set) {
      if (set < smallest) continue;
      real_v best = least[set] + costs[0];
      int_v way = lobes[set];
#pragma unroll
      for (int own = SUBSETS - 1; own > 0; --own) {
        if ((own & set) != own) continue;
        const real_v cost = least[set ^ own] + costs[own];
        const int_v less = cost < best;
        way = less ? lobes[set ^ own] + j * nibbles(own) : way;
        best = less ? cost : best;
      }
      least[set] = best;
      lobes[set] = way;
    }
  }
  const int_v way = lobes[SUBSETS - 1];
  int way_of_lane[MULTUM_VECTOR_WIDTH];
  STORE_V(way, way_of_lane);
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) chosen[slot + lane] = way_of_lane[lane];

  for (int j = 0; j < MULTUM_LOBES; ++j) {
    LobeLanes sums;
    sums.x = sums.y = sums.z = sums.amplitude = (real_v)(0.0f);
    for (int i = 0; i < NORMALS; ++i) {
      const int_v mine = ((way >> (4 * i)) & 15) == j;
      sums.x += mine ? samples[i].x : (real_v)(0.0f);
      sums.y += mine ? samples[i].y : (real_v)(0.0f);
      sums.z += mine ? samples[i].z : (real_v)(0.0f);
      sums.amplitude += mine ? (real_v)(1.0f) : (real_v)(0.0f);
    }
    real_v scatter = (real_v)(0.0f);
    for (int i = 0; i < NORMALS; ++i) {
      const int_v mine = ((way >> (4 * i)) & 15) == j;
      real_v sum = sample_scatter(samples[i]);
      for (int k = 0; k < i; ++k) {
        const int_v both = mine & (((way >> (4 * k)) & 15) == j);
        scatter +=
            both ? squared_distance(samples[i], samples[k]) + (sum + sample_scatter(samples[k])) : (real_v)(0.0f);
      }
      scatter += mine ? sum : (real_v)(0.0f);
    }
    LobeLanes lobe = lobe_of_sums(sums, scatter);
    const int_v is_empty = sums.amplitude == 0.0f;
    if (ANY_V(is_empty)) {  // a lobe without normals gets the direction and spread of the parent's lobe
      const LobeLanes inherited = gather((__global const float*)(parent + j * parent_size), parents.place[0]);
      lobe.x = is_empty ? inherited.x : lobe.x;
      lobe.y = is_empty ? inherited.y : lobe.y;
      lobe.z = is_empty ? inherited.z : lobe.z;
    }
    lobe.amplitude = sums.amplitude / NORMALS;
    float4 of_lanes[MULTUM_VECTOR_WIDTH];
    transpose_back(lobe.x, lobe.y, lobe.z, lobe.amplitude, of_lanes);
#pragma unroll
    for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane)
      if (texel_list[slot + lane] >= 0)
        vstore4(of_lanes[lane], j * level_size + places.own[lane], (__global float*)level);
  }
}

// Computes three features of each lobe: a_j y_j = 1/4 sum of its normals' y.
// One work-item handles one slot.
//   value_x, value_y, value_z [map_window_rows * map_width]
//   chosen   [slot]                            from movmf_choose
//   features [plane][window_rows * width][3]   planes first_plane + lobe written: premultiplied by the amplitude
// The kernel is memory bound.
__kernel void movmf_feature_chosen(__global const float* value_x, __global const float* value_y,
                                   __global const float* value_z, __global const int* texel_list,
                                   __global const int* chosen, __global float* features, MultumMovmfFit fit,
                                   int first_plane) {
  const int slot = (int)get_global_id(0);
  if (slot >= fit.slot_count) return;
  const int texel = texel_list[slot];
  if (texel < 0) return;
  const int x = texel_column(texel, &fit), y = texel_row(texel, &fit);
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    float sum[3] = {0.0f, 0.0f, 0.0f};
    for (int i = 0; i < NORMALS; ++i) {
      const size_t source = covered_pair(x, y, i / 2, &fit) + i % 2;
      if (((chosen[slot] >> (4 * i)) & 15) != j) continue;
      sum[0] += value_x[source];
      sum[1] += value_y[source];
      sum[2] += value_z[source];
    }
    __global float* out = features + ((first_plane + j) * level_window_size(&fit) + texel) * 3;
    for (int c = 0; c < 3; ++c) out[c] = sum[c] / NORMALS;
  }
}

// The loops over all points and links of a system, as vector code.
#pragma once

#include <cstddef>

namespace taut::direct {

/// Arrays of points or links in D = 2 or 3 axes: D rows of n numbers, n a multiple of kLanes, one
/// row behind the other. Link i joins the points i and i+1. Loops run over whole rows: behind a
/// span's last point stands a link whose constants are zero, and so do a number before and some
/// behind each array.
namespace kernels {

/// u_i = (q_{i+1} - q_i) / rest_i: the unit directions of links, as far as lengths hold.
void directions(int axes, std::size_t n, const double* q, const double* inverse_rest, double* u);

/// What neighbouring links make of the tensions' system (see solve_chain()): with the cosine c of
/// the angle between them, off = beside c and turned = (beside^2) (1 - c^2) + apart.
void neighbours(int axes, std::size_t n, const double* u, const double* beside, const double* apart,
                double* off, double* turned);

/// right_i = weight_i |u'_i|^2, u' the directions' rates: what centripetal acceleration asks for.
void centripetal(int axes, std::size_t n, const double* v, const double* inverse_rest,
                 const double* weight, double* right);

/// right_i = weight_i (|u_i| - 1): how far links are too long. Returns the largest of |u| - 1.
double excess(int axes, std::size_t n, const double* u, const double* weight, double* right);

/// right_i = weight_i u_i . u'_i: how fast links lengthen.
void lengthening(int axes, std::size_t n, const double* u, const double* v,
                 const double* inverse_rest, const double* weight, double* right);

/// What the unknowns x (tensions, scaled) do to points: out_i = after_i x_i u_i - before_i x_{i-1}
/// u_{i-1} + falls_i g, g one number per axis.
void pull(int axes, std::size_t n, const double* u, const double* x, const double* after,
          const double* before, const double* falls, const double* g, double* out);

/// The same without g, added to `out`.
void push(int axes, std::size_t n, const double* u, const double* x, const double* after,
          const double* before, double* out);

/// right_i = weight_i per_square (|d_i|^2 - 1) / 2: the pull that keeps the lengths of links d,
/// over the time whose square is 1 / per_square. Returns the largest of (|d|^2 - 1) / 2.
double shake(int axes, std::size_t n, double per_square, const double* weight, const double* d,
             double* right);

/// The largest |x_{i+1} - x_i| / rest_i of any axis.
double steepest(int axes, std::size_t n, const double* x, const double* inverse_rest);

/// The state at the share s of a step of h (s) from one state to another, by Hermite's cubic.
void hermite(std::size_t n, double h, double s, const double* q0, const double* v0,
             const double* q1, const double* v1, double* q, double* v);

/// y += factor x.
void add(std::size_t n, double factor, const double* x, double* y);

/// The sum of squares of n numbers, four sums at a time.
double squares(std::size_t n, const double* x);

}  // namespace kernels
}  // namespace taut::direct

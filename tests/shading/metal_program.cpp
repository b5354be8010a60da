// SPDX-License-Identifier: Apache-2.0
// Runs multum_lobes.metal as a C++ program, with a replacement for metal_stdlib. Reads the table and the cases of
// shading_languages_test.py from stdin as floats, and writes eight floats per case.
#include "multum_lobes.metal"

#include <cstdio>
#include <vector>

static std::vector<float> read_floats(size_t count) {
  std::vector<float> values(count);
  if (fread(values.data(), sizeof(float), count, stdin) != count) throw 1;
  return values;
}

int main() {
  const std::vector<float> size = read_floats(2);
  const int side = static_cast<int>(size[0]);
  const auto count = static_cast<size_t>(size[1]);
  const std::vector<float> table = read_floats(static_cast<size_t>(side * side * 4)), cases = read_floats(count * 16);
  const texture2d<float> texture{table.data(), side, side};
  for (size_t i = 0; i < count; ++i) {
    const float* c = &cases[16 * i];
    const float4 lobe(c[0], c[1], c[2], c[3]);
    const float3 l(c[4], c[5], c[6]), v(c[8], c[9], c[10]), h(c[12], c[13], c[14]);
    const float s = c[15];
    const float facets = multum_movmf_blinn_phong(lobe, h, s);
    const float cosine = multum_movmf_highlight_cosine(lobe, h, l, multum_vmf_kappa(1.0f / (s + 2.0f)));
    const float out[] = {multum_movmf_lambert(lobe, l), facets * cosine,
                         multum_movmf_ggx_specular(texture, sampler(), lobe, l, v, h, c[7]),
                         multum_schlick(float3(c[11]), dot(v, h)).x};
    fwrite(out, sizeof(float), 4, stdout);
    const float3 normal = multum_movmf_drawn_normal(lobe, float2(c[11], c[7]));
    const float2 pixel(100.0f * l.x + 200.0f, 100.0f * l.y + 200.0f);
    const float drawn[] = {normal.x, normal.y, normal.z, multum_blue_noise(texture, sampler(), pixel, floor(s)).y};
    fwrite(drawn, sizeof(float), 4, stdout);
  }
}

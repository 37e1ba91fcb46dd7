// Light baked by Tyndall. The JSON file beside this one names the textures and their boxes. Filter
// them linearly, clamped to the edge. Bind a black texture for each one that was not baked.
uniform sampler3D density;      // extinction [1/length]
uniform sampler3D emission;     // emitted radiance per length [W/(area sr length)]
uniform sampler3D inscatter;    // mean radiance over all directions [W/(area sr)]
uniform sampler3D inscatter_x;  // slope of the radiance along x, y, z
uniform sampler3D inscatter_y;
uniform sampler3D inscatter_z;
uniform vec3 density_min, density_max;  // "box_min", "box_max" of density and of emission
uniform vec3 light_min, light_max;      // "box_min", "box_max" of the other textures

bool is_within(vec3 q) {
  return all(greaterThanEqual(q, vec3(0.0))) && all(lessThanEqual(q, vec3(1.0)));
}

// Extinction at p, in world space; 0 outside the box.
float extinction(vec3 p) {
  vec3 q = (p - density_min) / (density_max - density_min);
  return is_within(q) ? texture(density, q).r : 0.0;
}

// Radiance that the medium emits at p, per length.
vec3 emitted(vec3 p) {
  vec3 q = (p - density_min) / (density_max - density_min);
  return is_within(q) ? texture(emission, q).rgb : vec3(0.0);
}

// The Henyey-Greenstein phase function [1/sr]; `cosine` of the scattering angle.
float henyey_greenstein(float cosine, float g) {
  float narrow = 1.0 - abs(g);
  float turned = g < 0.0 ? -cosine : cosine;
  float spread = narrow * narrow + 2.0 * abs(g) * abs(1.0 - turned);
  return 0.0795774715 * (1.0 - g * g) / (spread * sqrt(spread));
}

// One channel of scattered_light(): a Henyey-Greenstein lobe about the light's direction with the
// same mean and slope as mean + g dot(direction, slope), which could be negative.
float scattered_lobe(float mean, vec3 slope, vec3 direction, float g) {
  float steepness = length(slope);
  if (!(mean > 0.0) || !(steepness > 0.0)) return mean > 0.0 ? mean : 0.0;
  float narrowed = g * min(steepness / (3.0 * mean), 1.0);
  return 12.5663706 * mean * henyey_greenstein(dot(direction, slope) / steepness, narrowed);
}

// Radiance scattered at p towards `direction` (a unit vector), per unit of extinction.
// albedo: of the medium; g: the mean cosine of its phase function.
vec3 scattered_light(vec3 p, vec3 direction, vec3 albedo, float g) {
  vec3 q = (p - light_min) / (light_max - light_min);
  vec3 mean = texture(inscatter, q).rgb;
  vec3 x = texture(inscatter_x, q).rgb;
  vec3 y = texture(inscatter_y, q).rgb;
  vec3 z = texture(inscatter_z, q).rgb;
  return albedo * vec3(scattered_lobe(mean.r, vec3(x.r, y.r, z.r), direction, g),
                       scattered_lobe(mean.g, vec3(x.g, y.g, z.g), direction, g),
                       scattered_lobe(mean.b, vec3(x.b, y.b, z.b), direction, g));
}

// Transmittance from p, within the box, to the boundary of the box along `direction`.
float transmittance(vec3 p, vec3 direction, int steps) {
  vec3 ends = mix(density_min, density_max, step(vec3(0.0), direction));
  vec3 ways = abs(ends - p) / max(abs(direction), vec3(1e-6));
  float stride = min(ways.x, min(ways.y, ways.z)) / float(steps);
  float depth = 0.0;
  for (int i = 0; i < steps; ++i) {
    float way = stride * (float(i) + 0.5);
    depth += extinction(p + way * direction);
  }
  return exp(-stride * depth);
}

// Single scattering of a distant light, per unit of extinction: for bakes with --multiple-only, add
// it to scattered_light() once for each light. towards_light: a unit vector; irradiance: on a plane
// perpendicular to it.
vec3 scattered_once(vec3 p, vec3 direction, vec3 towards_light, vec3 irradiance, vec3 albedo,
                    float g, int steps) {
  return albedo * irradiance * henyey_greenstein(-dot(direction, towards_light), g)
      * transmittance(p, towards_light, steps);
}

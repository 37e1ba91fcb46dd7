// Light baked by Tyndall. The textures and their boxes are those that the JSON beside names;
// linear filter, clamped to the edge. Black textures stand for what was not baked.
uniform sampler3D density;      // extinction [1/length]
uniform sampler3D emission;     // radiance that the matter emits per length [W/(area sr length)]
uniform sampler3D inscatter;    // mean radiance over all directions [W/(area sr)]
uniform sampler3D inscatter_x;  // its slope along x, y, z
uniform sampler3D inscatter_y;
uniform sampler3D inscatter_z;
uniform vec3 density_min, density_max;  // "box_min", "box_max" of density and of emission
uniform vec3 light_min, light_max;      // those of the others

bool is_within(vec3 q) {
  return all(greaterThanEqual(q, vec3(0.0))) && all(lessThanEqual(q, vec3(1.0)));
}

// Extinction at p, in world space; 0 outside the box.
float extinction(vec3 p) {
  vec3 q = (p - density_min) / (density_max - density_min);
  return is_within(q) ? texture(density, q).r : 0.0;
}

// Radiance that matter at p emits of its own, per length: fire.
vec3 emitted(vec3 p) {
  vec3 q = (p - density_min) / (density_max - density_min);
  return is_within(q) ? texture(emission, q).rgb : vec3(0.0);
}

// Radiance that matter at p scatters towards `direction` (a unit vector), per unit of extinction.
// albedo: of the matter; g: the mean cosine of its phase function.
vec3 scattered_light(vec3 p, vec3 direction, vec3 albedo, float g) {
  vec3 q = (p - light_min) / (light_max - light_min);
  vec3 slope = direction.x * texture(inscatter_x, q).rgb + direction.y * texture(inscatter_y, q).rgb
      + direction.z * texture(inscatter_z, q).rgb;
  // A series cut off after its first order may dip below 0.
  return albedo * max(texture(inscatter, q).rgb + g * slope, vec3(0.0));
}

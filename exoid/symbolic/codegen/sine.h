/* Sine without a library call, so that loops with it vectorise: reduced to a half turn, then its Taylor series, whose
   first term left out is below 1e-16 there. Good to 4e-16 for the few radians of a joint. */
static inline double exoid_sin(double x) {
  const double k = rint(x * 0.31830988618379067154);
  const double y = x - k * 3.14159265358979323846, z = y * y;
  const double sign = 1.0 - 2.0 * fabs(k - 2.0 * rint(0.5 * k));
  double p = 1.9572941063391263e-20;
  p = p * z - 8.2206352466243297e-18;
  p = p * z + 2.8114572543455208e-15;
  p = p * z - 7.6471637318198165e-13;
  p = p * z + 1.6059043836821613e-10;
  p = p * z - 2.5052108385441719e-08;
  p = p * z + 2.7557319223985893e-06;
  p = p * z - 1.9841269841269841e-04;
  p = p * z + 8.3333333333333333e-03;
  p = p * z - 1.6666666666666667e-01;
  return sign * (y + y * z * p);
}

// Compiled for x86-64-v3: what check.py has to find in it.
double planted_fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
unsigned long planted_shift(unsigned long x, unsigned n) { return x << n; }

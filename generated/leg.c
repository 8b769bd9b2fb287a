/* Written by `exoid generate` through SymPy and CasADi; never edited by hand. See the header. */
/* How to prefix internal symbols */
#ifdef CASADI_CODEGEN_PREFIX
  #define CASADI_NAMESPACE_CONCAT(NS, ID) _CASADI_NAMESPACE_CONCAT(NS, ID)
  #define _CASADI_NAMESPACE_CONCAT(NS, ID) NS ## ID
  #define CASADI_PREFIX(ID) CASADI_NAMESPACE_CONCAT(CODEGEN_PREFIX, ID)
#else
  #define CASADI_PREFIX(ID) leg_ ## ID
#endif

#include <math.h>

#ifndef casadi_real
#define casadi_real double
#endif

#ifndef casadi_int
#define casadi_int long long int
#endif

/* Add prefix to internal symbols */
#define casadi_f0 CASADI_PREFIX(f0)
#define casadi_f1 CASADI_PREFIX(f1)
#define casadi_f2 CASADI_PREFIX(f2)
#define casadi_f3 CASADI_PREFIX(f3)
#define casadi_f4 CASADI_PREFIX(f4)
#define casadi_f5 CASADI_PREFIX(f5)
#define casadi_f6 CASADI_PREFIX(f6)
#define casadi_s0 CASADI_PREFIX(s0)
#define casadi_s1 CASADI_PREFIX(s1)
#define casadi_s2 CASADI_PREFIX(s2)
#define casadi_s3 CASADI_PREFIX(s3)
#define casadi_s4 CASADI_PREFIX(s4)
#define casadi_s5 CASADI_PREFIX(s5)
#define casadi_s6 CASADI_PREFIX(s6)
#define casadi_sq CASADI_PREFIX(sq)

/* Symbol visibility in DLLs */
#ifndef CASADI_SYMBOL_EXPORT
  #if defined(_WIN32) || defined(__WIN32__) || defined(__CYGWIN__)
    #if defined(STATIC_LINKED)
      #define CASADI_SYMBOL_EXPORT
    #else
      #define CASADI_SYMBOL_EXPORT __declspec(dllexport)
    #endif
  #elif defined(__GNUC__) && defined(GCC_HASCLASSVISIBILITY)
    #define CASADI_SYMBOL_EXPORT __attribute__ ((visibility ("default")))
  #else
    #define CASADI_SYMBOL_EXPORT
  #endif
#endif

casadi_real casadi_sq(casadi_real x) { return x*x;}

/* Configuration this file was compiled with */
CASADI_SYMBOL_EXPORT void leg_casadi_version(int* major, int* minor, int* patch) {
  *major = 3;
  *minor = 8;
  *patch = 2;
}
CASADI_SYMBOL_EXPORT int leg_casadi_int_size(void) { return (int) sizeof(casadi_int); }
CASADI_SYMBOL_EXPORT int leg_casadi_real_size(void) { return (int) sizeof(casadi_real); }

static const casadi_int casadi_s0[3] = {9, 1, 1};
static const casadi_int casadi_s1[3] = {8, 1, 1};
static const casadi_int casadi_s2[3] = {0, 1, 1};
static const casadi_int casadi_s3[3] = {10, 1, 1};
static const casadi_int casadi_s4[3] = {2, 1, 1};
static const casadi_int casadi_s5[3] = {4, 1, 1};
static const casadi_int casadi_s6[3] = {1, 1, 1};

/* leg_columns:(i0[9],i1[8],i2[0],i3[0])->(o0[10]) */
static int casadi_f0(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem) {
  casadi_real a0, a1, a2, a3, a4, a5, a6, a7, a8, a9;
  a0=arg[0]? arg[0][5] : 0;
  a1=2.4525000000000002e+01;
  a2=arg[0]? arg[0][1] : 0;
  a3=sin(a2);
  a4=(a1*a3);
  a5=(a0+a4);
  if (res[0]!=0) res[0][0]=a5;
  a5=arg[0]? arg[0][6] : 0;
  a6=-2.4525000000000002e+01;
  a6=(a6*a3);
  a6=(a5+a6);
  if (res[0]!=0) res[0][1]=a6;
  a6=(a0+a5);
  if (res[0]!=0) res[0][2]=a6;
  a6=arg[0]? arg[0][2] : 0;
  a3=cos(a6);
  a5=(a5*a3);
  a7=arg[0]? arg[0][4] : 0;
  a8=casadi_sq(a7);
  a9=sin(a6);
  a8=(a8*a9);
  a5=(a5-a8);
  a8=(2.*a0);
  a8=(a8*a3);
  a5=(a5+a8);
  a2=(a2+a6);
  a2=sin(a2);
  a1=(a1*a2);
  a5=(a5+a1);
  a2=-2.;
  a6=arg[0]? arg[0][3] : 0;
  a2=(a2*a6);
  a2=(a2*a7);
  a2=(a2*a9);
  a5=(a5+a2);
  if (res[0]!=0) res[0][3]=a5;
  a0=(a0*a3);
  a3=casadi_sq(a6);
  a3=(a3*a9);
  a0=(a0+a3);
  a0=(a0+a1);
  if (res[0]!=0) res[0][4]=a0;
  if (res[0]!=0) res[0][5]=a4;
  a4=arg[0]? arg[0][7] : 0;
  if (res[0]!=0) res[0][6]=a4;
  if (res[0]!=0) res[0][7]=a6;
  a6=arg[0]? arg[0][8] : 0;
  if (res[0]!=0) res[0][8]=a6;
  if (res[0]!=0) res[0][9]=a7;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_columns(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem){
  return casadi_f0(arg, res, iw, w, mem);
}

CASADI_SYMBOL_EXPORT int leg_columns_checkout(void) {
  return 0;
}

CASADI_SYMBOL_EXPORT void leg_columns_release(int mem) {
}

CASADI_SYMBOL_EXPORT void leg_columns_incref(void) {
}

CASADI_SYMBOL_EXPORT void leg_columns_decref(void) {
}

CASADI_SYMBOL_EXPORT casadi_int leg_columns_n_in(void) { return 4;}

CASADI_SYMBOL_EXPORT casadi_int leg_columns_n_out(void) { return 1;}

CASADI_SYMBOL_EXPORT casadi_real leg_columns_default_in(casadi_int i) {
  switch (i) {
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_columns_name_in(casadi_int i) {
  switch (i) {
    case 0: return "i0";
    case 1: return "i1";
    case 2: return "i2";
    case 3: return "i3";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_columns_name_out(casadi_int i) {
  switch (i) {
    case 0: return "o0";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_columns_sparsity_in(casadi_int i) {
  switch (i) {
    case 0: return casadi_s0;
    case 1: return casadi_s1;
    case 2: return casadi_s2;
    case 3: return casadi_s2;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_columns_sparsity_out(casadi_int i) {
  switch (i) {
    case 0: return casadi_s3;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT int leg_columns_work(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4;
  if (sz_res) *sz_res = 1;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = 0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_columns_work_bytes(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4*sizeof(const casadi_real*);
  if (sz_res) *sz_res = 1*sizeof(casadi_real*);
  if (sz_iw) *sz_iw = 0*sizeof(casadi_int);
  if (sz_w) *sz_w = 0*sizeof(casadi_real);
  return 0;
}

/* leg_inverse_dynamics:(i0[9],i1[8],i2[0],i3[0])->(o0[2]) */
static int casadi_f1(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem) {
  casadi_real a00, a01, a02, a03, a04, a05, a06, a07, a08, a09, a10, a11;
  casadi_real a12;
  a00=arg[0]? arg[0][5] : 0;
  a01=2.4525000000000002e+01;
  a02=arg[0]? arg[0][1] : 0;
  a03=sin(a02);
  a04=(a01*a03);
  a05=(a00+a04);
  a06=arg[1]? arg[1][0] : 0;
  a05=(a05*a06);
  a06=arg[0]? arg[0][6] : 0;
  a07=-2.4525000000000002e+01;
  a07=(a07*a03);
  a07=(a06+a07);
  a03=arg[1]? arg[1][1] : 0;
  a07=(a07*a03);
  a05=(a05+a07);
  a07=arg[0]? arg[0][2] : 0;
  a08=cos(a07);
  a09=(a06*a08);
  a10=arg[0]? arg[0][4] : 0;
  a11=casadi_sq(a10);
  a12=sin(a07);
  a11=(a11*a12);
  a09=(a09-a11);
  a11=(2.*a00);
  a11=(a11*a08);
  a09=(a09+a11);
  a02=(a02+a07);
  a02=sin(a02);
  a01=(a01*a02);
  a09=(a09+a01);
  a02=-2.;
  a07=arg[0]? arg[0][3] : 0;
  a02=(a02*a07);
  a02=(a02*a10);
  a02=(a02*a12);
  a09=(a09+a02);
  a02=arg[1]? arg[1][2] : 0;
  a09=(a09*a02);
  a05=(a05+a09);
  a09=arg[1]? arg[1][3] : 0;
  a04=(a04*a09);
  a05=(a05+a04);
  a04=arg[0]? arg[0][7] : 0;
  a09=arg[1]? arg[1][4] : 0;
  a04=(a04*a09);
  a05=(a05+a04);
  a04=arg[1]? arg[1][5] : 0;
  a04=(a07*a04);
  a05=(a05+a04);
  if (res[0]!=0) res[0][0]=a05;
  a06=(a00+a06);
  a06=(a06*a03);
  a00=(a00*a08);
  a07=casadi_sq(a07);
  a07=(a07*a12);
  a00=(a00+a07);
  a00=(a00+a01);
  a00=(a00*a02);
  a06=(a06+a00);
  a00=arg[0]? arg[0][8] : 0;
  a02=arg[1]? arg[1][6] : 0;
  a00=(a00*a02);
  a06=(a06+a00);
  a00=arg[1]? arg[1][7] : 0;
  a10=(a10*a00);
  a06=(a06+a10);
  if (res[0]!=0) res[0][1]=a06;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_inverse_dynamics(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem){
  return casadi_f1(arg, res, iw, w, mem);
}

CASADI_SYMBOL_EXPORT int leg_inverse_dynamics_checkout(void) {
  return 0;
}

CASADI_SYMBOL_EXPORT void leg_inverse_dynamics_release(int mem) {
}

CASADI_SYMBOL_EXPORT void leg_inverse_dynamics_incref(void) {
}

CASADI_SYMBOL_EXPORT void leg_inverse_dynamics_decref(void) {
}

CASADI_SYMBOL_EXPORT casadi_int leg_inverse_dynamics_n_in(void) { return 4;}

CASADI_SYMBOL_EXPORT casadi_int leg_inverse_dynamics_n_out(void) { return 1;}

CASADI_SYMBOL_EXPORT casadi_real leg_inverse_dynamics_default_in(casadi_int i) {
  switch (i) {
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_inverse_dynamics_name_in(casadi_int i) {
  switch (i) {
    case 0: return "i0";
    case 1: return "i1";
    case 2: return "i2";
    case 3: return "i3";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_inverse_dynamics_name_out(casadi_int i) {
  switch (i) {
    case 0: return "o0";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_inverse_dynamics_sparsity_in(casadi_int i) {
  switch (i) {
    case 0: return casadi_s0;
    case 1: return casadi_s1;
    case 2: return casadi_s2;
    case 3: return casadi_s2;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_inverse_dynamics_sparsity_out(casadi_int i) {
  switch (i) {
    case 0: return casadi_s4;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT int leg_inverse_dynamics_work(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4;
  if (sz_res) *sz_res = 1;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = 0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_inverse_dynamics_work_bytes(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4*sizeof(const casadi_real*);
  if (sz_res) *sz_res = 1*sizeof(casadi_real*);
  if (sz_iw) *sz_iw = 0*sizeof(casadi_int);
  if (sz_w) *sz_w = 0*sizeof(casadi_real);
  return 0;
}

/* leg_forward_dynamics:(i0[9],i1[8],i2[0],i3[0],i4[2])->(o0[2]) */
static int casadi_f2(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem) {
  casadi_real a00, a01, a02, a03, a04, a05, a06, a07, a08, a09, a10;
  a00=arg[1]? arg[1][1] : 0;
  a01=2.4525000000000002e+01;
  a02=arg[0]? arg[0][1] : 0;
  a03=sin(a02);
  a04=(a01*a03);
  a05=arg[1]? arg[1][0] : 0;
  a06=(a04*a05);
  a07=-2.4525000000000002e+01;
  a07=(a07*a03);
  a07=(a07*a00);
  a06=(a06+a07);
  a07=arg[0]? arg[0][2] : 0;
  a02=(a02+a07);
  a02=sin(a02);
  a01=(a01*a02);
  a02=arg[0]? arg[0][4] : 0;
  a03=casadi_sq(a02);
  a08=sin(a07);
  a03=(a03*a08);
  a03=(a01-a03);
  a09=-2.;
  a10=arg[0]? arg[0][3] : 0;
  a09=(a09*a10);
  a09=(a09*a02);
  a09=(a09*a08);
  a03=(a03+a09);
  a09=arg[1]? arg[1][2] : 0;
  a03=(a03*a09);
  a06=(a06+a03);
  a03=arg[1]? arg[1][3] : 0;
  a04=(a04*a03);
  a06=(a06+a04);
  a04=arg[0]? arg[0][7] : 0;
  a03=arg[1]? arg[1][4] : 0;
  a04=(a04*a03);
  a06=(a06+a04);
  a04=arg[1]? arg[1][5] : 0;
  a04=(a10*a04);
  a06=(a06+a04);
  a04=arg[4]? arg[4][0] : 0;
  a06=(a06-a04);
  a04=(a00*a06);
  a07=cos(a07);
  a03=(a09*a07);
  a03=(a00+a03);
  a10=casadi_sq(a10);
  a10=(a10*a08);
  a10=(a10+a01);
  a10=(a10*a09);
  a01=arg[0]? arg[0][8] : 0;
  a08=arg[1]? arg[1][6] : 0;
  a01=(a01*a08);
  a10=(a10+a01);
  a01=arg[1]? arg[1][7] : 0;
  a02=(a02*a01);
  a10=(a10+a02);
  a02=arg[4]? arg[4][1] : 0;
  a10=(a10-a02);
  a02=(a03*a10);
  a04=(a04-a02);
  a07=(2.*a07);
  a09=(a09*a07);
  a05=(a05+a09);
  a00=(a05*a00);
  a09=casadi_sq(a03);
  a00=(a00-a09);
  a04=(a04/a00);
  a04=(-a04);
  if (res[0]!=0) res[0][0]=a04;
  a05=(a05*a10);
  a03=(a03*a06);
  a05=(a05-a03);
  a05=(a05/a00);
  a05=(-a05);
  if (res[0]!=0) res[0][1]=a05;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_forward_dynamics(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem){
  return casadi_f2(arg, res, iw, w, mem);
}

CASADI_SYMBOL_EXPORT int leg_forward_dynamics_checkout(void) {
  return 0;
}

CASADI_SYMBOL_EXPORT void leg_forward_dynamics_release(int mem) {
}

CASADI_SYMBOL_EXPORT void leg_forward_dynamics_incref(void) {
}

CASADI_SYMBOL_EXPORT void leg_forward_dynamics_decref(void) {
}

CASADI_SYMBOL_EXPORT casadi_int leg_forward_dynamics_n_in(void) { return 5;}

CASADI_SYMBOL_EXPORT casadi_int leg_forward_dynamics_n_out(void) { return 1;}

CASADI_SYMBOL_EXPORT casadi_real leg_forward_dynamics_default_in(casadi_int i) {
  switch (i) {
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_forward_dynamics_name_in(casadi_int i) {
  switch (i) {
    case 0: return "i0";
    case 1: return "i1";
    case 2: return "i2";
    case 3: return "i3";
    case 4: return "i4";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_forward_dynamics_name_out(casadi_int i) {
  switch (i) {
    case 0: return "o0";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_forward_dynamics_sparsity_in(casadi_int i) {
  switch (i) {
    case 0: return casadi_s0;
    case 1: return casadi_s1;
    case 2: return casadi_s2;
    case 3: return casadi_s2;
    case 4: return casadi_s4;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_forward_dynamics_sparsity_out(casadi_int i) {
  switch (i) {
    case 0: return casadi_s4;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT int leg_forward_dynamics_work(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 5;
  if (sz_res) *sz_res = 1;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = 0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_forward_dynamics_work_bytes(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 5*sizeof(const casadi_real*);
  if (sz_res) *sz_res = 1*sizeof(casadi_real*);
  if (sz_iw) *sz_iw = 0*sizeof(casadi_int);
  if (sz_w) *sz_w = 0*sizeof(casadi_real);
  return 0;
}

/* leg_mass_matrix:(i0[9],i1[8],i2[0],i3[0])->(o0[4]) */
static int casadi_f3(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem) {
  casadi_real a0, a1, a2, a3;
  a0=arg[1]? arg[1][0] : 0;
  a1=arg[1]? arg[1][2] : 0;
  a2=arg[0]? arg[0][2] : 0;
  a2=cos(a2);
  a3=(2.*a2);
  a3=(a1*a3);
  a0=(a0+a3);
  if (res[0]!=0) res[0][0]=a0;
  a0=arg[1]? arg[1][1] : 0;
  a1=(a1*a2);
  a1=(a0+a1);
  if (res[0]!=0) res[0][1]=a1;
  if (res[0]!=0) res[0][2]=a1;
  if (res[0]!=0) res[0][3]=a0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_mass_matrix(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem){
  return casadi_f3(arg, res, iw, w, mem);
}

CASADI_SYMBOL_EXPORT int leg_mass_matrix_checkout(void) {
  return 0;
}

CASADI_SYMBOL_EXPORT void leg_mass_matrix_release(int mem) {
}

CASADI_SYMBOL_EXPORT void leg_mass_matrix_incref(void) {
}

CASADI_SYMBOL_EXPORT void leg_mass_matrix_decref(void) {
}

CASADI_SYMBOL_EXPORT casadi_int leg_mass_matrix_n_in(void) { return 4;}

CASADI_SYMBOL_EXPORT casadi_int leg_mass_matrix_n_out(void) { return 1;}

CASADI_SYMBOL_EXPORT casadi_real leg_mass_matrix_default_in(casadi_int i) {
  switch (i) {
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_mass_matrix_name_in(casadi_int i) {
  switch (i) {
    case 0: return "i0";
    case 1: return "i1";
    case 2: return "i2";
    case 3: return "i3";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_mass_matrix_name_out(casadi_int i) {
  switch (i) {
    case 0: return "o0";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_mass_matrix_sparsity_in(casadi_int i) {
  switch (i) {
    case 0: return casadi_s0;
    case 1: return casadi_s1;
    case 2: return casadi_s2;
    case 3: return casadi_s2;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_mass_matrix_sparsity_out(casadi_int i) {
  switch (i) {
    case 0: return casadi_s5;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT int leg_mass_matrix_work(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4;
  if (sz_res) *sz_res = 1;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = 0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_mass_matrix_work_bytes(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4*sizeof(const casadi_real*);
  if (sz_res) *sz_res = 1*sizeof(casadi_real*);
  if (sz_iw) *sz_iw = 0*sizeof(casadi_int);
  if (sz_w) *sz_w = 0*sizeof(casadi_real);
  return 0;
}

/* leg_coriolis:(i0[9],i1[8],i2[0],i3[0])->(o0[4]) */
static int casadi_f4(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem) {
  casadi_real a0, a1, a2, a3, a4, a5;
  a0=5.0000000000000000e-01;
  a1=arg[0]? arg[0][4] : 0;
  a1=(a0*a1);
  a2=arg[1]? arg[1][2] : 0;
  a3=arg[0]? arg[0][2] : 0;
  a3=sin(a3);
  a4=(-a3);
  a4=(2.*a4);
  a4=(a2*a4);
  a5=(a1*a4);
  if (res[0]!=0) res[0][0]=a5;
  a5=arg[0]? arg[0][3] : 0;
  a0=(a0*a5);
  a0=(a0*a4);
  a4=(-a0);
  if (res[0]!=0) res[0][1]=a4;
  a2=(a2*a3);
  a2=(2.*a2);
  a1=(a1*a2);
  a0=(a0-a1);
  if (res[0]!=0) res[0][2]=a0;
  a0=0.;
  if (res[0]!=0) res[0][3]=a0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_coriolis(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem){
  return casadi_f4(arg, res, iw, w, mem);
}

CASADI_SYMBOL_EXPORT int leg_coriolis_checkout(void) {
  return 0;
}

CASADI_SYMBOL_EXPORT void leg_coriolis_release(int mem) {
}

CASADI_SYMBOL_EXPORT void leg_coriolis_incref(void) {
}

CASADI_SYMBOL_EXPORT void leg_coriolis_decref(void) {
}

CASADI_SYMBOL_EXPORT casadi_int leg_coriolis_n_in(void) { return 4;}

CASADI_SYMBOL_EXPORT casadi_int leg_coriolis_n_out(void) { return 1;}

CASADI_SYMBOL_EXPORT casadi_real leg_coriolis_default_in(casadi_int i) {
  switch (i) {
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_coriolis_name_in(casadi_int i) {
  switch (i) {
    case 0: return "i0";
    case 1: return "i1";
    case 2: return "i2";
    case 3: return "i3";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_coriolis_name_out(casadi_int i) {
  switch (i) {
    case 0: return "o0";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_coriolis_sparsity_in(casadi_int i) {
  switch (i) {
    case 0: return casadi_s0;
    case 1: return casadi_s1;
    case 2: return casadi_s2;
    case 3: return casadi_s2;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_coriolis_sparsity_out(casadi_int i) {
  switch (i) {
    case 0: return casadi_s5;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT int leg_coriolis_work(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4;
  if (sz_res) *sz_res = 1;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = 0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_coriolis_work_bytes(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4*sizeof(const casadi_real*);
  if (sz_res) *sz_res = 1*sizeof(casadi_real*);
  if (sz_iw) *sz_iw = 0*sizeof(casadi_int);
  if (sz_w) *sz_w = 0*sizeof(casadi_real);
  return 0;
}

/* leg_gravity:(i0[9],i1[8],i2[0],i3[0])->(o0[2]) */
static int casadi_f5(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem) {
  casadi_real a0, a1, a2, a3, a4, a5;
  a0=2.4525000000000002e+01;
  a1=arg[0]? arg[0][1] : 0;
  a2=sin(a1);
  a3=(a0*a2);
  a4=arg[1]? arg[1][0] : 0;
  a4=(a3*a4);
  a5=-2.4525000000000002e+01;
  a5=(a5*a2);
  a2=arg[1]? arg[1][1] : 0;
  a5=(a5*a2);
  a4=(a4+a5);
  a5=arg[0]? arg[0][2] : 0;
  a1=(a1+a5);
  a1=sin(a1);
  a0=(a0*a1);
  a1=arg[1]? arg[1][2] : 0;
  a0=(a0*a1);
  a4=(a4+a0);
  a1=arg[1]? arg[1][3] : 0;
  a3=(a3*a1);
  a4=(a4+a3);
  if (res[0]!=0) res[0][0]=a4;
  if (res[0]!=0) res[0][1]=a0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_gravity(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem){
  return casadi_f5(arg, res, iw, w, mem);
}

CASADI_SYMBOL_EXPORT int leg_gravity_checkout(void) {
  return 0;
}

CASADI_SYMBOL_EXPORT void leg_gravity_release(int mem) {
}

CASADI_SYMBOL_EXPORT void leg_gravity_incref(void) {
}

CASADI_SYMBOL_EXPORT void leg_gravity_decref(void) {
}

CASADI_SYMBOL_EXPORT casadi_int leg_gravity_n_in(void) { return 4;}

CASADI_SYMBOL_EXPORT casadi_int leg_gravity_n_out(void) { return 1;}

CASADI_SYMBOL_EXPORT casadi_real leg_gravity_default_in(casadi_int i) {
  switch (i) {
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_gravity_name_in(casadi_int i) {
  switch (i) {
    case 0: return "i0";
    case 1: return "i1";
    case 2: return "i2";
    case 3: return "i3";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_gravity_name_out(casadi_int i) {
  switch (i) {
    case 0: return "o0";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_gravity_sparsity_in(casadi_int i) {
  switch (i) {
    case 0: return casadi_s0;
    case 1: return casadi_s1;
    case 2: return casadi_s2;
    case 3: return casadi_s2;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_gravity_sparsity_out(casadi_int i) {
  switch (i) {
    case 0: return casadi_s4;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT int leg_gravity_work(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4;
  if (sz_res) *sz_res = 1;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = 0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_gravity_work_bytes(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 4*sizeof(const casadi_real*);
  if (sz_res) *sz_res = 1*sizeof(casadi_real*);
  if (sz_iw) *sz_iw = 0*sizeof(casadi_int);
  if (sz_w) *sz_w = 0*sizeof(casadi_real);
  return 0;
}

/* leg_jacobian:(i0[9],i1[8],i2[0],i3[0],i4)->(o0[4]) */
static int casadi_f6(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem) {
  casadi_real a0, a1, a2, a3, a4, a5;
  a0=4.0000000000000002e-01;
  a1=arg[0]? arg[0][1] : 0;
  a2=cos(a1);
  a2=(a0*a2);
  a3=arg[4]? arg[4][0] : 0;
  a4=arg[0]? arg[0][2] : 0;
  a4=(a1+a4);
  a5=cos(a4);
  a5=(a3*a5);
  a2=(a2+a5);
  if (res[0]!=0) res[0][0]=a2;
  a1=sin(a1);
  a0=(a0*a1);
  a4=sin(a4);
  a3=(a3*a4);
  a0=(a0+a3);
  if (res[0]!=0) res[0][1]=a0;
  if (res[0]!=0) res[0][2]=a5;
  if (res[0]!=0) res[0][3]=a3;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_jacobian(const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, int mem){
  return casadi_f6(arg, res, iw, w, mem);
}

CASADI_SYMBOL_EXPORT int leg_jacobian_checkout(void) {
  return 0;
}

CASADI_SYMBOL_EXPORT void leg_jacobian_release(int mem) {
}

CASADI_SYMBOL_EXPORT void leg_jacobian_incref(void) {
}

CASADI_SYMBOL_EXPORT void leg_jacobian_decref(void) {
}

CASADI_SYMBOL_EXPORT casadi_int leg_jacobian_n_in(void) { return 5;}

CASADI_SYMBOL_EXPORT casadi_int leg_jacobian_n_out(void) { return 1;}

CASADI_SYMBOL_EXPORT casadi_real leg_jacobian_default_in(casadi_int i) {
  switch (i) {
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_jacobian_name_in(casadi_int i) {
  switch (i) {
    case 0: return "i0";
    case 1: return "i1";
    case 2: return "i2";
    case 3: return "i3";
    case 4: return "i4";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const char* leg_jacobian_name_out(casadi_int i) {
  switch (i) {
    case 0: return "o0";
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_jacobian_sparsity_in(casadi_int i) {
  switch (i) {
    case 0: return casadi_s0;
    case 1: return casadi_s1;
    case 2: return casadi_s2;
    case 3: return casadi_s2;
    case 4: return casadi_s6;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT const casadi_int* leg_jacobian_sparsity_out(casadi_int i) {
  switch (i) {
    case 0: return casadi_s5;
    default: return 0;
  }
}

CASADI_SYMBOL_EXPORT int leg_jacobian_work(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 5;
  if (sz_res) *sz_res = 1;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = 0;
  return 0;
}

CASADI_SYMBOL_EXPORT int leg_jacobian_work_bytes(casadi_int *sz_arg, casadi_int* sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
  if (sz_arg) *sz_arg = 5*sizeof(const casadi_real*);
  if (sz_res) *sz_res = 1*sizeof(casadi_real*);
  if (sz_iw) *sz_iw = 0*sizeof(casadi_int);
  if (sz_w) *sz_w = 0*sizeof(casadi_real);
  return 0;
}



/* Loops over samples: `state` (n, 9), `memory` (n, K), `extra` and `out` row by row. */
#ifdef __cplusplus
extern "C" {
#endif

CASADI_SYMBOL_EXPORT void leg_columns_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out) {
  long k;
  for (k = 0; k < n; ++k) {
    const casadi_real *arg[5];
    casadi_real *res[1];
    arg[0] = state + k * 9;
    arg[1] = linear;
    arg[2] = shape;
    arg[3] = memory ? memory + k * 0 : 0;
    arg[4] = extra ? extra + k * 0 : 0;
    res[0] = out + k * 10;
    leg_columns(arg, res, 0, 0, 0);
  }
}

CASADI_SYMBOL_EXPORT void leg_inverse_dynamics_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out) {
  long k;
  for (k = 0; k < n; ++k) {
    const casadi_real *arg[5];
    casadi_real *res[1];
    arg[0] = state + k * 9;
    arg[1] = linear;
    arg[2] = shape;
    arg[3] = memory ? memory + k * 0 : 0;
    arg[4] = extra ? extra + k * 0 : 0;
    res[0] = out + k * 2;
    leg_inverse_dynamics(arg, res, 0, 0, 0);
  }
}

CASADI_SYMBOL_EXPORT void leg_forward_dynamics_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out) {
  long k;
  for (k = 0; k < n; ++k) {
    const casadi_real *arg[5];
    casadi_real *res[1];
    arg[0] = state + k * 9;
    arg[1] = linear;
    arg[2] = shape;
    arg[3] = memory ? memory + k * 0 : 0;
    arg[4] = extra ? extra + k * 2 : 0;
    res[0] = out + k * 2;
    leg_forward_dynamics(arg, res, 0, 0, 0);
  }
}

CASADI_SYMBOL_EXPORT void leg_mass_matrix_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out) {
  long k;
  for (k = 0; k < n; ++k) {
    const casadi_real *arg[5];
    casadi_real *res[1];
    arg[0] = state + k * 9;
    arg[1] = linear;
    arg[2] = shape;
    arg[3] = memory ? memory + k * 0 : 0;
    arg[4] = extra ? extra + k * 0 : 0;
    res[0] = out + k * 4;
    leg_mass_matrix(arg, res, 0, 0, 0);
  }
}

CASADI_SYMBOL_EXPORT void leg_coriolis_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out) {
  long k;
  for (k = 0; k < n; ++k) {
    const casadi_real *arg[5];
    casadi_real *res[1];
    arg[0] = state + k * 9;
    arg[1] = linear;
    arg[2] = shape;
    arg[3] = memory ? memory + k * 0 : 0;
    arg[4] = extra ? extra + k * 0 : 0;
    res[0] = out + k * 4;
    leg_coriolis(arg, res, 0, 0, 0);
  }
}

CASADI_SYMBOL_EXPORT void leg_gravity_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out) {
  long k;
  for (k = 0; k < n; ++k) {
    const casadi_real *arg[5];
    casadi_real *res[1];
    arg[0] = state + k * 9;
    arg[1] = linear;
    arg[2] = shape;
    arg[3] = memory ? memory + k * 0 : 0;
    arg[4] = extra ? extra + k * 0 : 0;
    res[0] = out + k * 2;
    leg_gravity(arg, res, 0, 0, 0);
  }
}

CASADI_SYMBOL_EXPORT void leg_jacobian_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out) {
  long k;
  for (k = 0; k < n; ++k) {
    const casadi_real *arg[5];
    casadi_real *res[1];
    arg[0] = state + k * 9;
    arg[1] = linear;
    arg[2] = shape;
    arg[3] = memory ? memory + k * 0 : 0;
    arg[4] = extra ? extra + k * 1 : 0;
    res[0] = out + k * 4;
    leg_jacobian(arg, res, 0, 0, 0);
  }
}
#ifdef __cplusplus
}
#endif

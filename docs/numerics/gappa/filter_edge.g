# The filter's edge value V = h5·(A × d) in f32 (certified.md, section 1): off by 6u of its permanent, but for
# the last sum, which is free.
#
# Each rounding has a share of each product that is in proportion to that product's size. So products of size 1
# are enough. Those of the first two components of h5 have the most roundings. With these four alone the permanent
# is 4, and 6u of it is 24u; second orders come to less than a hundredth of u.

a1 = add_rel<24>(c1, mo1);  A1 = c1 + mo1;
a2 = add_rel<24>(c2, mo2);  A2 = c2 + mo2;
a3 = add_rel<24>(c3, mo3);  A3 = c3 + mo3;
h1 = add_rel<24>(e1, mc1);  H1 = e1 + mc1;
h2 = add_rel<24>(e2, mc2);  H2 = e2 + mc2;
h3 = add_rel<24>(e3, mc3);  H3 = e3 + mc3;

r1 = sub_rel<24>(mul_rel<24>(a2, d3), mul_rel<24>(a3, d2));  R1 = A2 * d3 - A3 * d2;
r2 = sub_rel<24>(mul_rel<24>(a3, d1), mul_rel<24>(a1, d3));  R2 = A3 * d1 - A1 * d3;
r3 = sub_rel<24>(mul_rel<24>(a1, d2), mul_rel<24>(a2, d1));  R3 = A1 * d2 - A2 * d1;

v = add_rel<24>(mul_rel<24>(h1, r1), mul_rel<24>(h2, r2)) + mul_rel<24>(h3, r3);
V = (H1 * R1 + H2 * R2) + H3 * R3;

{ |A1| <= 1 /\ |A2| <= 1 /\ |A3| <= 1 /\ |H1| <= 1 /\ |H2| <= 1 /\ |H3| <= 1b-40 /\
  |d1| <= 1 /\ |d2| <= 1 /\ |d3| <= 1
  -> |v - V| <= BOUND }

# enough: 24600b-34
# short:  24500b-34

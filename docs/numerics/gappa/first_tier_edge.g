# U, V and W of the first tier in f64 (exact.md, section 3): off by 7w of their permanent. As in filter_edge.g,
# with the last sum: 28w.

a1 = add_rel<53>(c1, mo1);  A1 = c1 + mo1;
a2 = add_rel<53>(c2, mo2);  A2 = c2 + mo2;
a3 = add_rel<53>(c3, mo3);  A3 = c3 + mo3;
h1 = add_rel<53>(e1, mc1);  H1 = e1 + mc1;
h2 = add_rel<53>(e2, mc2);  H2 = e2 + mc2;
h3 = add_rel<53>(e3, mc3);  H3 = e3 + mc3;

r1 = sub_rel<53>(mul_rel<53>(a2, d3), mul_rel<53>(a3, d2));  R1 = A2 * d3 - A3 * d2;
r2 = sub_rel<53>(mul_rel<53>(a3, d1), mul_rel<53>(a1, d3));  R2 = A3 * d1 - A1 * d3;
r3 = sub_rel<53>(mul_rel<53>(a1, d2), mul_rel<53>(a2, d1));  R3 = A1 * d2 - A2 * d1;

v = add_rel<53>(add_rel<53>(mul_rel<53>(h1, r1), mul_rel<53>(h2, r2)), mul_rel<53>(h3, r3));
V = (H1 * R1 + H2 * R2) + H3 * R3;

{ |A1| <= 1 /\ |A2| <= 1 /\ |A3| <= 1 /\ |H1| <= 1 /\ |H2| <= 1 /\ |H3| <= 1b-80 /\
  |d1| <= 1 /\ |d2| <= 1 /\ |d3| <= 1
  -> |v - V| <= BOUND }

# enough: 28700b-63
# short:  28600b-63

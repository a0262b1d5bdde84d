# T = A·(h4 × h5) of the first tier in f64 (exact.md, section 3): off by 8w of its permanent. As in filter_edge.g,
# with the products of the first two components of A: 32w.

a1 = add_rel<53>(c1, mo1);  A1 = c1 + mo1;
a2 = add_rel<53>(c2, mo2);  A2 = c2 + mo2;
a3 = add_rel<53>(c3, mo3);  A3 = c3 + mo3;
g1 = add_rel<53>(b1, mc1);  G1 = b1 + mc1;
g2 = add_rel<53>(b2, mc2);  G2 = b2 + mc2;
g3 = add_rel<53>(b3, mc3);  G3 = b3 + mc3;
h1 = add_rel<53>(e1, mc1);  H1 = e1 + mc1;
h2 = add_rel<53>(e2, mc2);  H2 = e2 + mc2;
h3 = add_rel<53>(e3, mc3);  H3 = e3 + mc3;

n1 = sub_rel<53>(mul_rel<53>(g2, h3), mul_rel<53>(g3, h2));  N1 = G2 * H3 - G3 * H2;
n2 = sub_rel<53>(mul_rel<53>(g3, h1), mul_rel<53>(g1, h3));  N2 = G3 * H1 - G1 * H3;
n3 = sub_rel<53>(mul_rel<53>(g1, h2), mul_rel<53>(g2, h1));  N3 = G1 * H2 - G2 * H1;

t = add_rel<53>(add_rel<53>(mul_rel<53>(n1, a1), mul_rel<53>(n2, a2)), mul_rel<53>(n3, a3));
T = (N1 * A1 + N2 * A2) + N3 * A3;

{ |A1| <= 1 /\ |A2| <= 1 /\ |A3| <= 1b-80 /\ |G1| <= 1 /\ |G2| <= 1 /\ |G3| <= 1 /\
  |H1| <= 1 /\ |H2| <= 1 /\ |H3| <= 1
  -> |t - T| <= BOUND }

# enough: 32800b-63
# short:  32700b-63

#include "tools/report/page_style.h"

namespace bakelight::report {

// Colours g0 … g6 are those of Okabe & Ito, which people with any kind of colour vision can tell apart.
const char* pageStyle() {
  return R"(
:root { --paper: #fff; --ink: #1c2126; --soft: #5b6570; --rule: #d9dee3; --panel: #f5f7f9; --bar: #9db8d2;
  --c0: #0072b2; --c1: #d55e00; --c2: #009e73; --c3: #b0578d; --c4: #a97800; --c5: #2f8fc4; --c6: #333; }
@media screen and (prefers-color-scheme: dark) {
  :root { --paper: #14181c; --ink: #e6e9ec; --soft: #9aa5b0; --rule: #343c44; --panel: #1c2228; --bar: #3d5f82;
    --c0: #4aa8e0; --c1: #f08a3c; --c2: #2fc79a; --c3: #dd8fbd; --c4: #e0b040; --c5: #8accf0; --c6: #ccc; } }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0 auto; padding: 0 16px 48px; max-width: 1180px; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; overflow-wrap: break-word; }
h1 { font-size: 26px; line-height: 1.2; margin: 28px 0 4px; }
h2 { font-size: 19px; line-height: 1.3; margin: 40px 0 6px; padding-top: 10px; border-top: 1px solid var(--rule); }
h3 { font-size: 15px; margin: 22px 0 6px; }
p { margin: 6px 0; max-width: 74ch; }
.soft, caption, figcaption { color: var(--soft); }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(220px, 1fr)); gap: 12px; margin: 18px 0; }
.card { background: var(--panel); border-radius: 6px; padding: 10px 14px; min-width: 0; }
.card .role { font-size: 12px; color: var(--soft); text-transform: uppercase; letter-spacing: .05em; }
.card .name { font-weight: 600; }
.card dl { display: grid; grid-template-columns: auto 1fr; gap: 0 10px; margin: 4px 0 0; font-size: 13px; }
.card dt { color: var(--soft); } .card dd { margin: 0; font-variant-numeric: tabular-nums; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(320px, 100%), 1fr)); gap: 16px 20px; }
.plots figure { margin: 0; min-width: 0; }
.plots figcaption { color: var(--ink); font-weight: 600; font-size: 14px; }
svg.plot { display: block; width: 100%; height: auto; max-width: 560px; font-family: inherit; }
.area { fill: none; stroke: var(--rule); }
.grid { stroke: var(--rule); stroke-width: .6; }
.tick { font-size: 10px; fill: var(--soft); }
.axis { font-size: 11px; fill: var(--ink); }
.label { font-size: 10px; font-weight: 600; fill: var(--ink); }
.leader { stroke: var(--soft); stroke-width: .6; }
.front { fill: none; stroke: var(--soft); stroke-width: 1.2; stroke-dasharray: 4 3; }
.whisker { stroke: var(--c); stroke-width: 1; opacity: .55; }
.filled { fill: var(--c); stroke: var(--c); stroke-width: 1.2; }
.hollow { fill: var(--paper); fill-opacity: .6; stroke: var(--c); stroke-width: 1.2; }
path.filled { fill: none; stroke-width: 2.6; } path.hollow { fill: none; }
.g0 { --c: var(--c0); } .g1 { --c: var(--c1); } .g2 { --c: var(--c2); } .g3 { --c: var(--c3); }
.g4 { --c: var(--c4); } .g5 { --c: var(--c5); } .g6 { --c: var(--c6); }
.legend { display: flex; flex-wrap: wrap; gap: 2px 16px; margin: 8px 0; padding: 0; list-style: none; font-size: 13px; }
.legend svg { width: 14px; height: 14px; vertical-align: -2px; margin-right: 5px; overflow: visible; }
.scroll { overflow-x: auto; margin: 8px 0; }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 10px 4px 0; text-align: right; vertical-align: top; border-bottom: 1px solid var(--rule); white-space: nowrap; }
th { font-weight: 600; vertical-align: bottom; }
thead th .unit { display: block; font-weight: 400; color: var(--soft); }
th:first-child, td:first-child, .text { text-align: left; }
td.wrap { white-space: normal; min-width: 15em; }
td.least { font-weight: 700; }
.mark { display: inline-block; width: 11px; padding-left: 2px; color: var(--c2); text-align: left; }
.range { display: block; font-size: 11px; font-weight: 400; color: var(--soft); padding-right: 11px; }
.bars td { min-width: 108px; position: relative; }
.bars td:first-child { min-width: 0; }
.bar { display: block; height: 7px; background: var(--bar); border-radius: 2px; margin-top: 1px; min-width: 1px; }
.views { display: grid; gap: 8px; }
.pictures { display: grid; grid-template-columns: repeat(var(--n), minmax(0, 1fr)); gap: 12px; max-width: calc(var(--n) * 290px); }
.pictures figure { margin: 0; min-width: 0; }
.pictures img { display: block; width: 100%; height: auto; max-width: 320px; background: var(--panel); border-radius: 4px; margin-bottom: 4px; }
.pictures figcaption { font-size: 12px; line-height: 1.35; }
.pictures .name { color: var(--ink); font-weight: 600; display: block; }
svg.scale { display: block; width: 100%; max-width: 330px; height: auto; }
dl.terms dt { font-weight: 600; margin-top: 10px; } dl.terms dd { margin: 0; max-width: 74ch; }
code { font-family: ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: .92em; }
@media (max-width: 700px) {
  h1 { font-size: 22px; }
  .pictures { grid-template-columns: repeat(2, minmax(0, 1fr)); }
  table { font-size: 12px; }
  th:first-child, td:first-child { position: sticky; left: 0; background: var(--paper); white-space: normal;
    min-width: 142px; max-width: 152px; overflow-wrap: anywhere; }
  td:first-child { font-size: 11.5px; }
  td.wrap { min-width: 11em; }
}
@media print {
  @page { margin: 14mm; }
  :root { --bar: #a9bccd; --panel: #f2f2f2; }
  body { font-size: 10.5px; max-width: none; padding: 0; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
  h1 { font-size: 20px; margin-top: 0; } h2 { font-size: 14px; margin-top: 18px; } h3 { font-size: 11.5px; }
  h2, h3 { break-after: avoid; }
  .card, .plots figure, .pictures figure, .view, tr { break-inside: avoid; }
  .plots { grid-template-columns: repeat(2, 1fr); gap: 4px 16px; } svg.plot { max-width: 80mm; }
  .plots figcaption, .legend { font-size: 10.5px; } .pictures figcaption, .card dl { font-size: 8.5px; }
  .cards { grid-template-columns: repeat(auto-fit, minmax(120px, 1fr)); } .card { padding: 5px 9px; } .card .role { font-size: 8px; } .range { font-size: 7px; padding-right: 6px; } .mark { width: 6px; padding-left: 1px; }
  .pictures { grid-template-columns: repeat(var(--n), minmax(0, 1fr)); max-width: calc(var(--n) * 36mm); }
  .scroll { overflow: visible; }
  table { font-size: 8px; } th, td { padding-right: 5px; white-space: normal; } thead { display: table-header-group; }
  .bars td { min-width: 0; }
}
)";
}

}  // namespace bakelight::report

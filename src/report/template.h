#pragma once

namespace furrow::report {

// Colours hold at least 4.5:1 against their background (WCAG 2.1 AA).
inline constexpr const char* kStyle = R"css(
:root{color-scheme:light;--ink:#1d2421;--soft:#55605b;--line:#d5dbd8;--paper:#fff;--tint:#f4f7f5;--accent:#00614a;
--pass:#00614a;--fail:#a63a00;--open:#4c5660}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%;scroll-behavior:smooth}
body{margin:0;background:var(--paper);color:var(--ink);font:1rem/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
.page{max-width:62rem;margin:0 auto;padding:1.5rem 1.25rem 4rem}
header{border-bottom:3px solid var(--accent);padding-bottom:.8rem;margin-bottom:1.2rem}
h1{font-size:1.9rem;line-height:1.2;margin:0}
h2{font-size:1.35rem;line-height:1.25;margin:2.6rem 0 .8rem;padding-bottom:.25rem;border-bottom:1px solid var(--line)}
p{margin:.5rem 0;max-width:46rem;overflow-wrap:anywhere}
a{color:var(--accent)}
.subtitle{color:var(--soft);margin:.3rem 0 0}
.summary{background:var(--tint);border-left:5px solid var(--accent);padding:.8rem 1.1rem 1rem;border-radius:3px}
.summary h2{border:0;margin:0 0 .4rem;padding:0}
.summary p{font-size:1.06rem}
.tally,.failed{list-style:none;margin:.8rem 0 0;padding:0}
.tally{display:flex;flex-wrap:wrap;gap:.4rem 1.4rem}
.failed li{margin:.2rem 0}
nav ul{list-style:none;display:flex;flex-wrap:wrap;gap:.2rem 1.1rem;margin:1.1rem 0 0;padding:0}
.mark{display:inline-flex;align-items:center;gap:.4rem;font-weight:600;white-space:nowrap}
.mark svg{width:1.15em;height:1.15em;flex:none}
.pass .mark,.mark.pass{color:var(--pass)}
.fail .mark,.mark.fail{color:var(--fail)}
.open .mark,.mark.open{color:var(--open)}
.findings{list-style:none;margin:.8rem 0 1.2rem;padding:0}
.finding{display:grid;grid-template-columns:9rem 1fr;gap:.1rem 1rem;padding:.65rem .9rem;border:1px solid var(--line);border-left-width:5px;margin:0 0 -1px}
.finding.pass{border-left-color:var(--pass)}
.finding.fail{border-left-color:var(--fail)}
.finding.open{border-left-color:var(--open);border-left-style:dashed}
.finding p{margin:0}
.finding .title{font-weight:600}
.finding .detail{grid-column:2}
.finding .evidence{grid-column:2;color:var(--soft);font-size:.93rem}
figure{margin:1.4rem 0 1.8rem}
.scroll{overflow-x:auto}
.scroll:focus-visible{outline:2px solid var(--accent);outline-offset:2px}
figure img{display:block;width:100%;height:auto;border:1px solid var(--line)}
figure.narrow img{max-width:34rem}
figcaption{color:var(--soft);font-size:.93rem;margin-top:.45rem;max-width:50rem;overflow-wrap:anywhere}
figcaption b,caption b{color:var(--ink)}
table{border-collapse:collapse;font-size:.92rem;font-variant-numeric:tabular-nums;margin:.2rem 0}
caption{text-align:left;color:var(--soft);padding:.3rem 0 .4rem;caption-side:top}
th,td{padding:.28rem .7rem;text-align:left;border-bottom:1px solid var(--line);vertical-align:top}
thead th{border-bottom:2px solid var(--ink);min-width:4.2rem;line-height:1.25;vertical-align:bottom}
td{max-width:26rem}
tbody tr:nth-child(even){background:var(--tint)}
.num{text-align:right;white-space:nowrap}
.short{white-space:nowrap}
details{margin:.8rem 0}
summary{cursor:pointer;color:var(--accent);font-weight:600;padding:.2rem 0}
.provenance th{font-weight:600;white-space:nowrap;text-align:left}
.provenance td{overflow-wrap:anywhere;font-family:ui-monospace,"DejaVu Sans Mono",monospace;font-size:.86rem}
@media (max-width:640px){
.page{padding:1rem .9rem 3rem}
h1{font-size:1.5rem}
.finding{grid-template-columns:1fr}
.finding .detail,.finding .evidence{grid-column:1}
figure:not(.narrow) img{min-width:36rem}
.provenance th{white-space:normal}
}
@media print{
@page{margin:16mm}
body{font-size:10pt}
.page{max-width:none;padding:0}
nav,.download{display:none}
a{color:inherit;text-decoration:none}
.summary,.finding,figure,tr{break-inside:avoid}
h2{break-after:avoid}
.scroll{overflow:visible}
figure img{border:0;max-width:174mm}
thead{display:table-header-group}
*{-webkit-print-color-adjust:exact;print-color-adjust:exact}
}
)css";

// Verdicts differ by word and by shape, not by colour alone.
inline constexpr const char* kPassMark =
    R"(<svg viewBox="0 0 16 16" aria-hidden="true"><circle cx="8" cy="8" r="7.5" fill="currentColor"/><path d="M4.2 8.4l2.6 2.6 5-5.6" fill="none" stroke="#fff" stroke-width="2"/></svg>)";
inline constexpr const char* kFailMark =
    R"(<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M8 .6L15.8 15H.2z" fill="currentColor"/><path d="M8 5.6v4.6M8 11.6v2" fill="none" stroke="#fff" stroke-width="2"/></svg>)";
inline constexpr const char* kOpenMark =
    R"(<svg viewBox="0 0 16 16" aria-hidden="true"><circle cx="8" cy="8" r="6.8" fill="none" stroke="currentColor" stroke-width="1.6" stroke-dasharray="2.4 1.9"/><path d="M4.8 8h6.4" stroke="currentColor" stroke-width="2"/></svg>)";

inline constexpr const char* kPage = R"html(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="Furrow">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<link rel="icon" href="data:,">
<title>{{title}}</title>
<style>{{{style}}}</style>
</head>
<body>
<div class="page">
<header>
<h1>{{title}}</h1>
{{#subtitle}}<p class="subtitle">{{subtitle}}</p>
{{/subtitle}}
</header>
<main>
<section class="summary" aria-labelledby="summary">
<h2 id="summary">Summary</h2>
{{#summary}}
<p>{{text}}</p>
{{/summary}}
{{#has_tally}}
<ul class="tally" aria-label="Findings">
{{#tally}}
<li><span class="mark {{kind}}">{{{mark}}}{{count}} {{words}}</span></li>
{{/tally}}
</ul>
{{/has_tally}}
{{#has_failed}}
<ul class="failed" aria-label="Failed findings">
{{#failed}}
<li><a href="#finding-{{number}}">{{title}}</a>{{#value}}: {{value}}{{/value}}{{#limit}} ({{limit}}){{/limit}}</li>
{{/failed}}
</ul>
{{/has_failed}}
</section>
<nav aria-label="Contents"><ul>
{{#sections}}
<li><a href="#section-{{number}}">{{title}}</a></li>
{{/sections}}
{{#has_provenance}}
<li><a href="#provenance">Provenance</a></li>
{{/has_provenance}}
</ul></nav>
{{#sections}}
<section aria-labelledby="section-{{number}}">
<h2 id="section-{{number}}">{{title}}</h2>
{{#paragraphs}}
<p>{{text}}</p>
{{/paragraphs}}
{{#has_findings}}
<ul class="findings">
{{#findings}}
<li class="finding {{kind}}" id="finding-{{number}}">
<p><span class="mark">{{{mark}}}{{word}}</span></p>
<p class="title">{{title}}</p>
{{#has_detail}}<p class="detail">{{#value}}{{value}}{{/value}}{{#limit}} (limit: {{limit}}){{/limit}}</p>
{{/has_detail}}
{{#evidence}}<p class="evidence">{{evidence}}</p>
{{/evidence}}
</li>
{{/findings}}
</ul>
{{/has_findings}}
{{#figures}}
<figure id="figure-{{number}}"{{#narrow}} class="narrow"{{/narrow}}>
<div class="scroll" tabindex="0" role="group" aria-label="Figure {{number}}"><img src="{{{uri}}}" alt="{{caption}}" width="{{width}}" height="{{height}}"></div>
<figcaption><b>Figure {{number}}.</b> {{caption}}{{#data_uri}} <a class="download" download="{{name}}.csv" href="{{{data_uri}}}">Numbers (CSV, {{data_rows}})</a>{{/data_uri}}</figcaption>
</figure>
{{/figures}}
{{#tables}}
{{#collapsed}}
<details>
<summary>{{caption}} ({{rows_text}})</summary>
{{/collapsed}}
<div class="scroll" tabindex="0" role="group" aria-label="Table {{number}}">
<table>
<caption><b>Table {{number}}.</b> {{caption}}</caption>
<thead><tr>{{#columns}}<th scope="col"{{#num}} class="num"{{/num}}>{{text}}</th>{{/columns}}</tr></thead>
<tbody>
{{#rows}}
<tr>{{#cells}}<td{{#num}} class="num"{{/num}}{{#short}} class="short"{{/short}}>{{text}}</td>{{/cells}}</tr>
{{/rows}}
</tbody>
</table>
</div>
{{#collapsed}}
</details>
{{/collapsed}}
{{/tables}}
</section>
{{/sections}}
</main>
{{#has_provenance}}
<footer>
<section aria-labelledby="provenance">
<h2 id="provenance">Provenance</h2>
<div class="scroll" tabindex="0" role="group" aria-label="Provenance">
<table class="provenance"><tbody>
{{#provenance}}
<tr><th scope="row">{{name}}</th><td>{{value}}</td></tr>
{{/provenance}}
</tbody></table>
</div>
</section>
</footer>
{{/has_provenance}}
</div>
</body>
</html>
)html";

}  // namespace furrow::report
